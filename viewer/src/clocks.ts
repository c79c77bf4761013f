/** Seconds of the motion that shall be seen now. */
export type Clock = () => number;

/** Milliseconds that only grow; replaced in tests. */
export type Now = () => number;

const now: Now = () => performance.now();
const NEARNESS = 0.06; // s: a media element tells its time in steps; further off than that, something else happened

/** Runs from `start` seconds on, in real time. */
export function wallClock(start = 0, tell: Now = now): Clock {
  const began = tell();
  return () => start + (tell() - began) / 1000;
}

/** The time of a sound that a media element plays: runs smoothly between the steps in which the element tells it. */
export function mediaClock(media: Pick<HTMLMediaElement, 'currentTime' | 'paused' | 'playbackRate'>, tell: Now = now): Clock {
  let told = media.currentTime;
  let smooth = told;
  let at = tell();
  return () => {
    const moment = tell();
    const elapsed = ((moment - at) / 1000) * media.playbackRate;
    at = moment;
    const current = media.currentTime;
    if (media.paused) smooth = current;
    else {
      smooth += elapsed;
      if (Math.abs(smooth - current) > NEARNESS * Math.max(1, media.playbackRate)) smooth = current;
      else if (current !== told) smooth += 0.1 * (current - smooth);
    }
    told = current;
    return smooth;
  };
}

/** The time of a sound that an AudioContext plays: began at `startedAt` of the context, heard `outputLatency` later. */
export function contextClock(context: Pick<AudioContext, 'currentTime' | 'outputLatency'>, startedAt: number): Clock {
  return () => context.currentTime - startedAt - (context.outputLatency || 0);
}
