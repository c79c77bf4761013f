// Another take beside the open one: in its place (A/B), beside it, and its curves under the lanes.
import { MotionClip } from 'mien-viewer';
import * as api from './api';
import { button, make } from './dom';
import { Events } from './events';
import type { Playback } from './playback';
import type { Session } from './session';

export class Compared extends Events<{ change: void }> {
  readonly element = make('div', { class: 'compare', hidden: true });
  clip: MotionClip | undefined;
  private sound: ArrayBuffer | undefined;
  private shown: 'A' | 'B' | 'both' = 'A';
  private readonly buttons = new Map<string, HTMLButtonElement>();

  constructor(private readonly session: Session, private readonly playback: Playback) {
    super();
    for (const [name, title] of [['A', 'The take that is open'], ['B', 'The other take, with its sound'], ['both', 'Both, side by side']] as const) {
      const press = button(name, () => this.show(name), { 'aria-pressed': String(name === 'A'), title });
      this.buttons.set(name, press);
      this.element.append(press);
    }
  }

  async choose(take: string): Promise<void> {
    this.show('A');
    this.clip = undefined;
    if (take !== '') {
      await this.session.work(async (signal) => {
        await api.finished(await api.openTake(take), (told) => this.session.emit('busy', told), signal);
        const about = await api.take(take);
        const [values, sound] = await Promise.all([api.frames(take, 'edited', about.revision), api.sound(take)]);
        this.clip = new MotionClip(about.channels, about.fps, values, { seconds: about.seconds });
        this.sound = sound;
      });
    }
    this.element.hidden = this.clip === undefined;
    this.show(this.clip === undefined ? 'A' : 'both');
  }

  /** What is shown in place of the open take. */
  get instead(): MotionClip | undefined { return this.shown === 'B' ? this.clip : undefined; }

  /** What is shown beside it. */
  pose(): { channels: readonly string[]; values: Float32Array } | undefined {
    return this.shown === 'both' && this.clip !== undefined ? { channels: this.clip.channels, values: this.clip.sample(this.playback.now) } : undefined;
  }

  private show(name: 'A' | 'B' | 'both'): void {
    const { playback, session } = this;
    if ((name === 'B') !== (this.shown === 'B') && this.sound !== undefined && session.sound !== undefined && session.take !== undefined) {
      const [at, going] = [playback.now, playback.playing];
      const other = name === 'B';
      playback.load(other ? this.sound : session.sound, other ? this.clip?.seconds ?? 0 : session.take.seconds, session.take.fps);
      playback.seek(at);
      if (going) void playback.play();
    }
    this.shown = name;
    for (const [other, press] of this.buttons) press.setAttribute('aria-pressed', String(other === name));
    this.emit('change', undefined);
  }
}
