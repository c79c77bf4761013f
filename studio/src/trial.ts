// The line as a control under the finger would have it: performed by the server while one slides, heard and seen at once.
import { Speech } from './anchors';
import * as api from './api';
import { held, type Point } from './curves';
import type { Playback } from './playback';
import type { Session } from './session';
import type { Layer, Span, Take, TakeRequest } from './types';

const SETTLED_MS = 80; // a key press and a quick click want the result alone
const LONGEST = 20; // seconds of a line that is made anew in a moment

interface Line { phones: readonly Span[]; seconds: number }

export class Trial {
  /** A trial is what one hears and sees now. */
  heard = false;
  private wanted: (TakeRequest & { layer?: Layer }) | undefined;
  private aloud = false;
  private began: { at: number; playing: boolean } | undefined;
  private now: Line | undefined; // what is heard
  private making = false;
  private timer = 0;

  constructor(private readonly session: Session, private readonly playback: Playback) {
    playback.on('time', (at) => { // as long as the finger is there the line goes on
      if (!this.heard || !this.aloud || at < playback.seconds - 1e-3 || playback.playing) return;
      playback.seek(playback.loop?.[0] ?? 0);
      void playback.play();
    });
  }

  private get able(): boolean {
    const { take, working } = this.session;
    return take !== undefined && take.take !== 'beginning' && take.from_sound !== true && take.seconds <= LONGEST && !working;
  }

  /** What is heard of a control, and when. */
  get promise(): string { return this.able ? 'You hear it as you slide.' : 'The voice follows when you let go.'; }

  /** Has the line performed with these changes. `aloud`: it is played, too; otherwise only if it plays already. */
  ask(changes: TakeRequest & { layer?: Layer }, aloud: boolean): void {
    if (!this.able || (!aloud && !this.playback.playing)) return;
    this.began ??= { at: this.playback.now, playing: this.playback.playing };
    [this.wanted, this.aloud] = [changes, aloud];
    if (this.making) return;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.make(), SETTLED_MS);
  }

  /**
   * The finger is gone: all is as it was, unless the line is performed so now.
   *
   * @param performed whether that came about
   * @param on it is played on
   */
  end(performed?: Promise<boolean>, on = false): void {
    clearTimeout(this.timer);
    this.wanted = undefined;
    const { began, heard, playback } = this;
    this.began = undefined;
    if (began === undefined) return;
    if (!heard || performed === undefined) {
      if (heard) this.restore(began);
      else if (performed === undefined) this.session.show(this.session.layer);
      return;
    }
    this.aloud = false;
    if (!began.playing && !on) {
      playback.pause();
      playback.seek(this.moved(began.at, this.session.take as Take, this.now as Line));
    }
    void performed.then((done) => { if (done) this.heard = false; else this.restore(began); });
  }

  /** A slider that is let go where it was says nothing of it. */
  endsWith(slider: HTMLInputElement, tell: () => void): void {
    for (const name of ['pointerup', 'pointercancel', 'blur']) slider.addEventListener(name, () => window.setTimeout(() => {
      if (this.began === undefined || this.session.working) return;
      tell();
      this.end();
    }));
  }

  private restore(began: { at: number; playing: boolean }): void {
    const { playback, session, now } = this;
    this.heard = false;
    if (session.take === undefined || session.sound === undefined) return;
    const going = began.playing && playback.playing;
    playback.swap(session.sound, session.take.seconds, going && now !== undefined ? this.moved(playback.now, now, session.take) : began.at, going);
    session.show(session.layer);
  }

  private async make(): Promise<void> {
    const { session } = this;
    this.making = true;
    try {
      while (this.wanted !== undefined && session.take !== undefined) {
        const [asked, name] = [this.wanted, session.take.take];
        this.wanted = undefined;
        const { take: id } = await api.finished(await api.trial(name, asked), () => undefined);
        const [made, plain, sound] = await Promise.all([api.take(id as string), api.frames(id as string, 'plain', 0), api.sound(id as string)]);
        if (this.began !== undefined && session.take.take === name && !session.working) this.present(made, plain, sound);
      }
    } catch { // what is wrong is told when the line is performed so
      this.wanted = undefined;
    } finally {
      this.making = false;
    }
  }

  private present(made: Take, plain: Float32Array, sound: ArrayBuffer): void {
    const { playback, session } = this;
    const before = this.heard && this.now !== undefined ? this.now : session.take as Take;
    const at = this.moved(playback.now, before, made);
    [this.heard, this.now] = [true, made];
    session.show(session.layer, plain as Float32Array<ArrayBuffer>, new Speech(made.words, made.phones, made.seconds, made.line), made);
    playback.swap(sound, made.seconds, at, playback.playing || this.aloud);
  }

  /** The same moment of the line where it is spoken otherwise. */
  private moved(at: number, from: Line, to: Line): number {
    if (from.phones.length !== to.phones.length) return (at / from.seconds) * to.seconds;
    const points = from.phones.map(([, end], place): Point => [end, (to.phones[place] as Span)[1]]);
    return held([[0, 0], ...points], at, 'linear');
  }
}
