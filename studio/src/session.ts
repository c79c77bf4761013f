// One take on the table: its steps (undo and redo, across performances), and the frames that are shown. Whatever is done
// goes to the server's journal at once; while the server is away it is kept here, and handed over when it is back.
import { MotionClip } from 'mien-viewer';
import { Speech } from './anchors';
import { held } from './curves';
import * as api from './api';
import { Events } from './events';
import { performed, withBorder } from './layer';
import { articulated, felt, holding, layOver, reweighed, warped, type Intensity } from './performance';
import { emptyLayer, type About, type ChannelFacts, type Job, type Layer, type Lost, type Take, type Span, type Step, type TakeRequest } from './types';

interface Happenings {
  /** Another take, or the same one performed anew; `fresh`: the sound may be another too; `new`: another take. */
  take: { take: Take; fresh: boolean; other: boolean };
  /** The frames that are shown have changed. */
  frames: MotionClip;
  layer: Layer;
  lost: Lost[];
  busy: Job | null;
  problem: { message: string; field: string | null };
  /** The list of takes has changed. */
  list: void;
  /** What happens is safely with the server (`true`), or waits for it. */
  kept: boolean;
}

const RETRY_MS = 1500;
const UNSENT = 'mien-unsent';

export class Session extends Events<Happenings> {
  take: Take | undefined;
  speech = new Speech([], [], 0);
  lost: Lost[] = [];
  clip: MotionClip | undefined;
  sound: ArrayBuffer | undefined;
  steps: Step[] = [];
  at = 0;
  readonly facts: ReadonlyMap<string, ChannelFacts>;
  expressions: api.Expressions | undefined;
  private plain = new Float32Array(0);
  private neutral: Promise<Float32Array | null> | undefined;
  private restful: Float32Array | null = null; // `neutral`, once it is here
  private performedAs = '';
  private count = 0; // steps that the server has
  private kept = 0; // of those, how many are still as they are here
  private unsent = 0; // steps from here on are on their way
  private shownAt = 0; // the step that the server shows
  private sending: Promise<void> | undefined;
  private cancel: AbortController | undefined;

  constructor(readonly about: About) {
    super();
    this.facts = new Map(about.channels.map((channel) => [channel.name, channel]));
  }

  get layer(): Layer { return this.steps[this.at]?.layer ?? emptyLayer(); }
  get request(): TakeRequest { return this.steps[this.at]?.request ?? this.take?.request ?? {}; }
  get canUndo(): boolean { return this.at > 0; }
  get canRedo(): boolean { return this.at < this.steps.length - 1; }
  /** Whether everything is with the server. */
  get safe(): boolean { return this.sending === undefined; }

  // ------------------------------------------------------------ takes

  /** Performs the line as it is asked for: the take that is open, whose edits are laid on again, or a new one. */
  async perform(request: TakeRequest & { layer?: Layer; sound?: null }, recording?: File, anew = false): Promise<boolean> {
    const id = anew ? undefined : this.take?.take;
    return this.work(async (signal) => {
      await this.sending;
      const job = id === undefined ? await api.startTake(request, recording) : await this.surely(() => api.redo(id, request, recording));
      const done = await api.finished(job, (told) => this.told(told), signal);
      await this.showTake(done.take as string, id === undefined);
      this.emit('list', undefined);
    });
  }

  /** Performs the open take with the words and phones of a TextGrid. */
  async takeGrid(file: File): Promise<boolean> {
    return this.work(async (signal) => {
      await this.sending;
      const id = (this.take as Take).take;
      await api.finished(await api.textGrid(id, file), (told) => this.told(told), signal);
      await this.showTake(id, false);
    });
  }

  /** Opens a take that the studio keeps. */
  async open(id: string): Promise<boolean> {
    return this.work(async (signal) => {
      await this.sending;
      await api.finished(await api.openTake(id), (told) => this.emit('busy', told), signal);
      await this.showTake(id, id !== this.take?.take);
    });
  }

  /** Nothing is on the table any more. */
  leave(): void {
    [this.take, this.clip, this.sound, this.steps, this.at] = [undefined, undefined, undefined, [], 0];
    this.emit('list', undefined);
  }

  private beginning = '';

  /** How far a job is; the beginning of a long line is shown as soon as there is one. */
  private told(job: Job): void {
    this.emit('busy', job);
    const id = job.beginning;
    if (!id || id === this.beginning || job.state === 'done') return;
    this.beginning = id;
    void (async () => {
      const take = await api.take(id);
      const [plain, sound] = await Promise.all([api.frames(id, 'plain', take.revision), api.sound(id)]);
      if (this.cancel === undefined || this.beginning !== id) return; // the whole is there already
      const first = this.take?.take !== 'beginning';
      [this.steps, this.at, this.sound] = [[{ request: take.request, layer: emptyLayer(), sound: null }], 0, sound];
      this.accept({ ...take, take: 'beginning' }, plain, true, first);
    })().catch(() => undefined); // the whole comes anyway
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

  get working(): boolean { return this.cancel !== undefined; }
  stopWork(): void { this.cancel?.abort(); }

  private async showTake(id: string, other: boolean): Promise<void> {
    const [take, history] = await Promise.all([api.take(id), api.history(id)]);
    const [plain, sound] = await Promise.all([api.frames(id, 'plain', take.revision), api.sound(id)]);
    const wasBeginning = this.take?.take === 'beginning';
    this.beginning = '';
    this.steps = history.steps;
    this.at = this.shownAt = history.at;
    this.kept = this.count = history.steps.length;
    this.sound = sound;
    if (this.steps[this.at] !== undefined) (this.steps[this.at] as Step).layer = take.edits ?? this.layer;
    this.accept(take, plain, true, other && !wasBeginning);
    this.emit('layer', this.layer);
  }

  private accept(take: Take, plain: Float32Array, fresh: boolean, other = false): void {
    this.take = take;
    this.plain = plain as Float32Array<ArrayBuffer>;
    this.neutral = undefined;
    this.restful = null;
    this.speech = new Speech(take.words, take.phones, take.seconds, take.line);
    this.performedAs = performed(this.layer);
    this.lost = take.lost ?? [];
    this.emit('take', { take, fresh, other });
    this.emit('lost', this.lost);
    this.show(this.layer);
    if (take.emotions.length > 0) window.setTimeout(() => { if (this.take === take) void this.withoutEmotion(); }, 300); // so that another emotion shows at once
  }

  /** A take that another window may have changed is read again. */
  async refresh(): Promise<void> {
    const { take } = this;
    if (take === undefined || take.take === 'beginning' || this.working || this.sending !== undefined) return;
    const now = await api.take(take.take).catch(() => undefined);
    if (now === undefined || this.take !== take || this.sending !== undefined) return;
    if (now.revision !== take.revision || now.at !== this.at || now.count !== this.steps.length) await this.open(take.take);
  }

  // ------------------------------------------------------------ what is shown

  /** Shows a layer while something is being dragged; nothing is kept yet. */
  show(layer: Layer, base: Float32Array = this.plain, speech: Speech = this.speech, take: Take | undefined = this.take): void {
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

  /** The performance without any emotion, as soon as it is here. */
  private async withoutEmotion(): Promise<Float32Array | null> {
    const { take } = this;
    if (take === undefined) return null;
    this.neutral ??= api.frames(take.take, 'neutral', take.revision).catch(() => null);
    const neutral = await this.neutral;
    if (neutral === null || neutral.length !== this.plain.length || take !== this.take) return null;
    this.restful = neutral;
    return neutral;
  }

  /** Shows an emotion with another intensity, as far as that can be guessed without the server. */
  async showIntensity(before: Intensity, after: Intensity): Promise<void> {
    const { take } = this;
    const neutral = await this.withoutEmotion();
    if (neutral === null || take === undefined) return;
    this.show(this.layer, reweighed(this.plain, neutral, take.channels.length, take.fps, before, after));
  }

  /** What an emotion does to the face at rest; undefined where that is not known. */
  mask(emotion: string): { channels: readonly string[]; values: number[] } | undefined {
    const values = this.expressions?.emotions[emotion];
    return values === undefined || this.expressions === undefined ? undefined : { channels: this.expressions.channels, values };
  }

  /** Shows the whole line in an emotion, as a guess: the server performs it when it is chosen. */
  showFeeling(emotion: string, strength: number): void {
    const { take } = this;
    if (take === undefined) return;
    if (this.restful === null) {
      void this.withoutEmotion();
      if (take.emotions.length > 0) return;
    }
    const mask = emotion === '' ? { channels: [], values: [] } : this.mask(emotion);
    if (mask !== undefined) this.show(this.layer, felt(this.restful ?? this.plain, take.channels, mask, strength, this.facts));
  }

  /** Shows the line articulated with another effort, as a guess. */
  showEffort(before: number, after: number): void {
    const { take } = this;
    if (take === undefined) return;
    const { efforts, jaw, lips } = this.about.effort;
    const gain = (gains: number[]): number => {
      const at = (effort: number): number => held(efforts.map((one, i): [number, number] => [one, gains[i] as number]), effort, 'linear');
      return at(after) / Math.max(at(before), 0.05);
    };
    this.show(this.layer, articulated(this.plain, take.channels, gain(jaw), gain(lips)));
  }

  /** Shows channels held at values, as a guess. */
  showHeld(channels: Readonly<Record<string, number>>): void {
    if (this.take !== undefined) this.show(this.layer, holding(this.plain, this.take.channels, channels));
  }

  // ------------------------------------------------------------ edits

  /** Keeps a changed layer, as a step of undo. */
  commit(layer: Layer): void {
    const now = this.steps[this.at];
    if (now === undefined || this.take?.take === 'beginning') return;
    if (JSON.stringify(layer) === JSON.stringify(now.layer)) {
      this.show(layer);
      return;
    }
    this.steps = [...this.steps.slice(0, this.at + 1), { ...now, layer }];
    this.kept = Math.min(this.kept, this.at + 1);
    this.at += 1;
    this.put();
  }

  undo(): void { this.go(this.at - 1); }
  redoEdit(): void { this.go(this.at + 1); }

  private go(to: number): void {
    if (to < 0 || to >= this.steps.length || this.working) return;
    this.at = to;
    this.put();
  }

  private put(): void {
    this.emit('layer', this.layer);
    if (this.sameSpeech() && performed(this.layer) === this.performedAs) this.show(this.layer);
    this.sending ??= this.send().finally(() => { this.sending = undefined; this.emit('kept', true); });
  }

  /** Whether the take on the table is performed as the step asks for it, but for edits. */
  private sameSpeech(): boolean {
    const [now, shown] = [this.steps[this.at], this.steps[this.shownAt]];
    return now !== undefined && shown !== undefined && now.sound === shown.sound && JSON.stringify(now.request) === JSON.stringify(shown.request);
  }

  /** Waits until the server has all edits. */
  async settled(): Promise<void> { await this.sending; }

  /** Sends steps until the server has the newest. */
  private async send(): Promise<void> {
    while (this.take !== undefined && (this.at !== this.shownAt || this.kept < this.steps.length || this.count > this.steps.length)) {
      const [id, at, count, keep] = [this.take.take, this.at, this.steps.length, this.kept];
      const step = this.steps[at] as Step;
      const again = !this.sameSpeech() || performed(step.layer) !== this.performedAs;
      if (again) this.emit('busy', { state: 'running', step: 'performing' });
      this.emit('kept', false);
      try {
        const changed = { keep, add: this.steps.slice(keep).map(({ layer }) => layer), at, count: this.count };
        this.unsent = keep;
        this.kept = count; // what is changed from now on is sent the next time
        const answer = await this.surely(() => api.putSteps(id, changed));
        if (answer.job !== undefined) {
          await api.finished(answer.job, (told) => this.emit('busy', told));
          await this.showTake(id, false);
          return;
        }
        const take = answer.take as Take;
        if (this.take.take !== id) return;
        this.count = count;
        this.shownAt = at;
        const gone = count - (take.count ?? count); // the oldest steps of too many
        if (gone > 0) {
          this.steps = this.steps.slice(gone);
          [this.at, this.shownAt, this.count, this.kept] = [this.at - gone, this.shownAt - gone, this.count - gone, this.kept - gone];
        }
        if (again) {
          const plain = await api.frames(id, 'plain', take.revision);
          if (this.take.take !== id) return;
          const { layer } = this;
          this.accept(take, plain, false);
          this.performedAs = performed(step.layer);
          if (layer !== step.layer) this.emit('layer', layer);
        } else {
          this.take = { ...this.take, revision: take.revision };
          this.lost = take.lost ?? [];
          this.emit('lost', this.lost);
        }
      } catch (problem) {
        this.tell(problem);
        await this.recover(id, problem);
        return;
      } finally {
        if (again) this.emit('busy', null);
      }
    }
    localStorage.removeItem(UNSENT);
  }

  /** The server refused a change: what it has counts. */
  private async recover(id: string, problem: unknown): Promise<void> {
    if (problem instanceof api.ApiError && problem.status !== api.GONE) await this.showTake(id, false).catch(() => undefined);
  }

  /** Asks until the server answers; a take that it does not know is handed to it. */
  private async surely<T>(act: () => Promise<T>): Promise<T> {
    for (let told = false; ;) {
      try {
        return await act();
      } catch (problem) {
        const { take } = this;
        if (!(problem instanceof api.ApiError) || take === undefined) throw problem;
        if (problem.status === 404) {
          await this.handBack(take.take);
          continue;
        }
        if (problem.status !== api.GONE) throw problem;
        if (!told) this.tell(problem);
        told = true;
        localStorage.setItem(UNSENT, JSON.stringify({ take: take.take, count: this.count, kept: Math.min(this.kept, this.unsent), at: this.at, add: this.steps.slice(Math.min(this.kept, this.unsent)) }));
        await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
      }
    }
  }

  /** Gives the take on the table to a server that does not know it. */
  private async handBack(id: string): Promise<void> {
    const known = this.steps.slice(0, this.count);
    const at = Math.min(this.shownAt, known.length - 1);
    const record = { name: this.take?.name ?? this.take?.text.slice(0, 40) ?? 'take', made: Date.now() / 1000, steps: known, at };
    await api.handBack(id, record, this.sound);
    this.emit('list', undefined);
  }

  /** Steps that a page kept which was closed while the server was away. */
  async bringUnsent(): Promise<void> {
    const content = localStorage.getItem(UNSENT);
    localStorage.removeItem(UNSENT);
    if (content === null) return;
    const { take, count, kept, at, add } = JSON.parse(content) as { take: string; count: number; kept: number; at: number; add: Step[] };
    await api.putSteps(take, { keep: kept, add: add.map(({ layer }) => layer), at, count }).catch(() => undefined); // it has other steps by now
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
