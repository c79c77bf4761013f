// One line on the table: its take, the layer of edits and its history, and the frames that are shown.
import { MotionClip } from 'mien-viewer';
import { Speech } from './anchors';
import * as api from './api';
import { Events } from './events';
import { performed, withBorder } from './layer';
import { layOver, reweighed, warped, type Intensity } from './performance';
import { emptyLayer, type About, type ChannelFacts, type Job, type Layer, type Lost, type Take, type Span, type TakeRequest } from './types';

interface Happenings {
  /** Another take, or the same one performed anew. */
  take: { take: Take; fresh: boolean };
  /** The frames that are shown have changed. */
  frames: MotionClip;
  layer: Layer;
  lost: Lost[];
  busy: Job | null;
  problem: { message: string; field: string | null };
}

const MOST_UNDO = 200;

export class Session extends Events<Happenings> {
  take: Take | undefined;
  speech = new Speech([], [], 0);
  layer = emptyLayer();
  lost: Lost[] = [];
  clip: MotionClip | undefined;
  sound: ArrayBuffer | undefined;
  readonly facts: ReadonlyMap<string, ChannelFacts>;
  private plain = new Float32Array(0);
  private neutral: Promise<Float32Array | null> | undefined;
  private undone: Layer[] = [];
  private done: Layer[] = [];
  private saved = '';
  private performedAs = '';
  private sending: Promise<void> | undefined;
  private cancel: AbortController | undefined;

  constructor(readonly about: About) {
    super();
    this.facts = new Map(about.channels.map((channel) => [channel.name, channel]));
  }

  get canUndo(): boolean { return this.done.length > 0; }
  get canRedo(): boolean { return this.undone.length > 0; }

  // ------------------------------------------------------------ takes

  /** Performs a new line. The edits of the one before stay with that one. */
  async perform(request: TakeRequest, recording?: File): Promise<void> {
    await this.work(async (signal) => {
      const job = await api.finished(await api.startTake(request, recording), (told) => this.emit('busy', told), signal);
      this.forget();
      await this.open(job.take as string);
    });
  }

  /** Performs the line again with some fields changed; the edits are laid over it again. */
  async redo(changed: TakeRequest): Promise<void> {
    const id = this.take?.take;
    if (id === undefined) return;
    await this.work(async (signal) => {
      await this.sending;
      const job = await api.finished(await api.redo(id, changed), (told) => this.emit('busy', told), signal);
      this.done = [];
      this.undone = [];
      await this.open(job.take as string);
    });
  }

  /** Runs a longer job; one at a time, its failures are told. */
  async work(job: (signal: AbortSignal) => Promise<void>): Promise<boolean> {
    if (this.cancel !== undefined) {
      this.emit('problem', { message: 'Something is still being made: wait for it or cancel it.', field: null });
      return false;
    }
    this.cancel = new AbortController();
    this.emit('busy', { state: 'queued' });
    try {
      await job(this.cancel.signal);
      return true;
    } catch (problem) {
      this.tell(problem);
      return false;
    } finally {
      this.cancel = undefined;
      this.emit('busy', null);
    }
  }

  stopWork(): void { this.cancel?.abort(); }

  private forget(): void {
    this.done = [];
    this.undone = [];
    this.layer = emptyLayer();
    this.lost = [];
  }

  private async open(id: string): Promise<void> {
    const take = await api.take(id);
    const [plain, sound] = await Promise.all([api.frames(id, 'plain', take.revision), api.sound(id)]);
    this.layer = take.edits ?? emptyLayer();
    this.saved = JSON.stringify(this.layer);
    this.sound = sound;
    this.accept(take, plain, true);
    this.emit('layer', this.layer);
  }

  private accept(take: Take, plain: Float32Array, fresh: boolean): void {
    this.take = take;
    this.plain = plain as Float32Array<ArrayBuffer>;
    this.neutral = undefined;
    this.speech = new Speech(take.words, take.phones, take.seconds, take.line);
    this.performedAs = performed(this.layer);
    this.lost = take.lost ?? [];
    this.emit('take', { take, fresh });
    this.emit('lost', this.lost);
    this.show(this.layer);
  }

  // ------------------------------------------------------------ edits

  /** Shows a layer while something is being dragged; nothing is kept yet. */
  show(layer: Layer, base: Float32Array = this.plain, speech: Speech = this.speech): void {
    const { take } = this;
    if (take === undefined) return;
    const values = base.slice();
    layOver(values, take.channels, take.fps, layer, speech, this.facts);
    this.clip = new MotionClip(take.channels, take.fps, values, { seconds: take.seconds });
    this.emit('frames', this.clip);
  }

  /** Shows the border after phone `place` at another moment: the motion is stretched with the phones. */
  showBorder(place: number, at: number): void {
    const { take } = this;
    if (take === undefined) return;
    const { words, phones } = withBorder(take.words, take.phones, place, at);
    const [begin, end] = [(phones[place] as Span)[0], (phones[place + 1] as Span)[1]];
    const from = [0, begin, (take.phones[place] as Span)[1], end, take.seconds];
    const to = [0, begin, at, end, take.seconds];
    const base = warped(this.plain, take.channels.length, take.fps, from, to);
    this.show(this.layer, base, new Speech(words, phones, take.seconds, take.line));
  }

  /** Shows an emotion with another intensity, as far as that can be guessed without the server. */
  async showIntensity(before: Intensity, after: Intensity): Promise<void> {
    const { take } = this;
    if (take === undefined) return;
    this.neutral ??= api.frames(take.take, 'neutral', take.revision).catch(() => null);
    const neutral = await this.neutral;
    if (neutral === null || neutral.length !== this.plain.length || take !== this.take) return;
    this.show(this.layer, reweighed(this.plain, neutral, take.channels.length, take.fps, before, after));
  }

  /** Keeps a changed layer, with a step of undo. */
  commit(layer: Layer): void {
    if (JSON.stringify(layer) === JSON.stringify(this.layer)) {
      this.show(this.layer);
      return;
    }
    this.done.push(this.layer);
    if (this.done.length > MOST_UNDO) this.done.shift();
    this.undone = [];
    this.put(layer);
  }

  undo(): void {
    const before = this.done.pop();
    if (before === undefined) return;
    this.undone.push(this.layer);
    this.put(before);
  }

  redoEdit(): void {
    const after = this.undone.pop();
    if (after === undefined) return;
    this.done.push(this.layer);
    this.put(after);
  }

  private put(layer: Layer): void {
    this.layer = layer;
    this.emit('layer', layer);
    if (performed(layer) === this.performedAs) this.show(layer);
    this.sending ??= this.send().finally(() => { this.sending = undefined; });
  }

  /** Waits until the server has all edits. */
  async settled(): Promise<void> { await this.sending; }

  /** Sends the layer, until the server has the newest. */
  private async send(): Promise<void> {
    while (this.take !== undefined && JSON.stringify(this.layer) !== this.saved) {
      const { layer } = this;
      const id = this.take.take;
      const again = performed(layer) !== this.performedAs;
      if (again) this.emit('busy', { state: 'running', step: 'performing' });
      try {
        const answer = await api.putEdits(id, layer);
        this.saved = JSON.stringify(layer);
        if (this.take.take !== id) return;
        if (again) {
          const [take, plain] = await Promise.all([answer.take ?? api.take(id), api.frames(id, 'plain', answer.revision)]);
          if (this.take.take !== id) return;
          this.accept(take, plain, false);
          this.performedAs = performed(layer);
        } else {
          this.take = { ...this.take, revision: answer.revision };
          this.lost = answer.lost ?? [];
          this.emit('lost', this.lost);
        }
      } catch (problem) {
        this.saved = JSON.stringify(layer); // it was refused: it is not sent again
        this.tell(problem);
        const before = this.done.pop();
        if (before !== undefined) this.put(before);
        return;
      } finally {
        if (again) this.emit('busy', null);
      }
    }
  }

  /** The layer of a file laid over this take. */
  async loadLayer(content: unknown): Promise<void> {
    const layer = content as Layer;
    if (typeof layer !== 'object' || layer === null || layer.format !== 'mien-edits' || !Array.isArray(layer.edits)) {
      this.emit('problem', { message: 'That file holds no edits of mien (mien-edits).', field: 'layer' });
      return;
    }
    this.commit(layer);
    await this.settled();
  }

  tell(problem: unknown, field: string | null = null): void {
    const told = problem instanceof Error ? problem.message : String(problem);
    this.emit('problem', { message: told, field: problem instanceof api.ApiError ? problem.field ?? field : field });
  }
}
