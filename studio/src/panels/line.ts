// What is said, by whom, in which mood. One button performs it: the take that is open keeps its edits.
import { button, field, make, options, showFault } from '../dom';
import type { Session } from '../session';
import type { Layer, TakeRequest } from '../types';
import { Emotions } from './emotions';
import type { Stage } from '../stage';
import { LineText } from './line_text';
import { Manner, withGaze } from './manner';
import type { Trial } from '../trial';
import * as api from '../api';

const EXAMPLE = 'I never said that. Maybe five people heard my voice!';
const AHEAD_MS = 400; // after the last key
const ENDED_MS = 50; // after a mark that ends a sentence
const DROP = 'or drop one';
const FIELDS = ['text', 'sound', 'emotion', 'voice', 'language', 'performer', 'speech_model', 'effort', 'prosody', 'voice_emotion', 'seed', 'fps'];
const MODELS: Record<string, string> = {
  '': 'as the performer has it', coarticulation: 'learned curves alone', graph: 'recorded motion, pieced together', both: 'curves with recorded motion on top',
};

export class LinePanel {
  readonly element = make('form', { class: 'panel', id: 'panel-line', 'aria-label': 'Line' });
  readonly emotions: Emotions;
  readonly text: LineText;
  private readonly file = make('input', { type: 'file', accept: 'audio/*,video/*,.wav,.flac,.mp3,.ogg,.m4a,.opus', class: 'visually-hidden' });
  private readonly fileName = make('span', { class: 'file-name' });
  private readonly noSound = button('Remove the recording', () => this.useSound(undefined), { class: 'small', hidden: true }, '×');
  private readonly voice = make('select');
  private readonly language = make('select');
  private readonly performer = make('select');
  private readonly model = make('select');
  readonly manner: Manner;
  private readonly prosody = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 0.5 });
  private readonly seed = make('input', { type: 'number', min: 0, step: 1, value: 0, inputmode: 'numeric' });
  private readonly fps = make('input', { type: 'number', min: 1, max: 240, step: 1, value: 60, inputmode: 'numeric' });
  private readonly go = make('button', { type: 'submit', class: 'primary', id: 'perform', title: 'Perform the line (Enter). Edits are kept.' }, 'Perform');
  private readonly anew = button('Start anew', () => void this.perform(true), { id: 'anew', disabled: true, title: 'Make another take, without the edits; this one stays in the list of takes' });
  private recording: File | undefined;
  private recorded = false; // the take that is open has a recording
  private grid: File | undefined; // a TextGrid for the recording that is chosen
  private writing = 0;
  private others: string[] = []; // emotions beside the one that is chosen

  constructor(private readonly session: Session, stage: Stage, trial: Trial, back: () => void, private readonly changed: () => void, hear: () => void) {
    this.emotions = new Emotions(session, stage, trial, back, (name, strength) => this.feel(name, strength), (name, strength) => this.felt(name, strength));
    this.manner = new Manner(session, stage, trial, back, (target) => this.look(target), async (aloud) => {
      const done = await this.again();
      if (done && aloud) hear();
      return done;
    });
    this.text = new LineText(session.about.emotions, () => void this.perform());
    this.text.value = EXAMPLE;
    this.fill();
    const drop = make('div', { class: 'drop' }, make('label', { class: 'button', for: 'field-sound' }, 'Open a recording …'), this.file, this.fileName, this.noSound);
    const more = make('details', { class: 'more' }, make('summary', {}, 'Voice, performer and more'),
      field('Voice', 'voice', this.voice),
      field('Language', 'language', this.language), field('Performer', 'performer', this.performer),
      field('How the mouth moves', 'speech_model', this.model),
      field('Brows and nods on accents', 'prosody', this.prosody),
      make('div', { class: 'pair' }, field('Variation (seed)', 'seed', this.seed), field('Frames per second', 'fps', this.fps)));
    const soundField = make('div', { class: 'field', 'data-field': 'sound' }, drop, make('p', { class: 'fault', id: 'fault-sound', role: 'alert', hidden: true }));
    this.file.id = 'field-sound';
    // A browser cannot point at a faulty number in a section that is shut, and would do nothing at all.
    more.addEventListener('invalid', () => { more.open = true; }, true);
    this.element.append(
      textField(this.text), soundField, make('div', { class: 'actions' }, this.go, this.anew),
      make('h3', {}, 'Emotion'), this.emotions.element, make('p', { class: 'fault', id: 'fault-emotion', role: 'alert', hidden: true }), this.manner.element, more);
    this.listen();
    this.tellSound();
  }

  private fill(): void {
    const { about } = this.session;
    const plain = (names: string[]): [string, string][] => names.map((name) => [name, name]);
    options(this.voice, [['', 'the best that is installed'], ...about.voices.map(({ name, language }): [string, string] => [name, `${name} (${language})`])]);
    options(this.language, [['', 'from the text'], ...plain(about.languages)]);
    options(this.performer, plain(about.performers));
    options(this.model, ['', ...about.speech_models].map((name): [string, string] => [name, MODELS[name] ?? name]));
  }

  private listen(): void {
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.perform();
    });
    this.file.addEventListener('change', () => this.useSound(this.file.files?.[0]));
    this.element.addEventListener('input', () => {
      this.changed();
      this.manner.look(this.text.value);
      clearTimeout(this.writing);
      this.writing = window.setTimeout(() => this.ahead(), /[.!?…。！？]["'”’)]*\s*$/.test(this.text.value) ? ENDED_MS : AHEAD_MS);
    });
    this.prosody.addEventListener('change', () => void this.again());
    this.session.on('take', ({ take, fresh }) => { if (fresh && take.take !== 'beginning') this.showRequest(); });
    this.session.on('list', () => this.tellSound());
    this.session.on('layer', () => this.showEmotion());
    this.session.on('busy', (job) => {
      this.go.disabled = job !== null;
      this.anew.disabled = job !== null || this.session.take === undefined;
    });
  }

  /** Takes a recording instead of a voice (undefined: a voice again). */
  useSound(file: File | undefined): void {
    const most = this.session.about.limits.upload_bytes;
    showFault('sound', null);
    if (file !== undefined && file.size > most) {
      showFault('sound', `${file.name} has ${(file.size / 1e6).toFixed(0)} MB; at most ${(most / 1e6).toFixed(0)} MB are taken`);
      return;
    }
    this.recording = file;
    this.grid = undefined;
    if (file === undefined) this.recorded = false;
    this.file.value = '';
    if (file !== undefined && (this.text.value === EXAMPLE || this.session.take !== undefined)) this.text.value = '';
    this.tellSound();
  }

  private tellSound(): void {
    const there = this.recording !== undefined || this.recorded;
    const grid = this.grid === undefined ? '' : ` and ${this.grid.name}`;
    this.fileName.textContent = `${this.recording?.name ?? (this.recorded ? 'the recording of this take' : DROP)}${grid}`;
    this.fileName.title = there ? this.fileName.textContent : 'A sound file, dropped anywhere on the page';
    this.noSound.hidden = !there;
    this.text.input.placeholder = there ? 'What is said in the recording? Empty: it is recognised.' : 'What shall be said?';
    this.voice.disabled = there;
    this.manner.withRecording(there);
    this.emotions.offerHeard(there);
    this.anew.disabled = this.session.take === undefined;
    this.go.textContent = this.session.take === undefined ? 'Perform' : 'Perform, keep edits';
  }

  /** Shows what the take that is open was asked for. */
  private showRequest(): void {
    const { request } = this.session;
    this.recording = undefined;
    this.recorded = this.session.take?.from_sound === true;
    this.text.value = this.recorded && !request.text ? this.session.take?.text ?? '' : request.text ?? '';
    this.voice.value = request.voice ?? '';
    this.language.value = request.language ?? '';
    this.performer.value = request.performer ?? 'default';
    this.model.value = request.speech_model ?? '';
    this.manner.set(request.effort ?? '', request.voice_emotion ?? 1, this.text.value);
    this.prosody.value = String(request.prosody ?? 0.5);
    this.seed.value = String(request.seed ?? 0);
    this.fps.value = String(Number(request.fps ?? 60));
    this.tellSound();
    this.showEmotion();
  }

  /** The panel shows what the lanes show: a drawn intensity counts, else what the take was asked for. */
  private showEmotion(): void {
    const { request, layer } = this.session;
    if (this.session.take === undefined) return;
    const asked = ([] as string[]).concat(request.emotion ?? []);
    const [first, ...others] = asked;
    this.others = others;
    const [name = '', strength = '0.7'] = (first ?? '').split(':');
    const drawn = layer.edits.find((edit) => edit.kind === 'intensity' && edit.emotion === name);
    const points = drawn?.kind === 'intensity' ? drawn.points : undefined;
    const mean = points === undefined || points.length === 0 ? Number(strength) : points.reduce((sum, { value }) => sum + value, 0) / points.length;
    this.emotions.set(name.replace(/\[.*$/, ''), Number.isFinite(mean) ? Math.min(mean, 1) : 0.7);
  }

  /** Performs the line in another emotion; a curve that was drawn for it gives way. */
  private async feel(name: string, strength: number): Promise<boolean> {
    return this.session.take === undefined ? false : this.session.perform(this.felt(name, strength));
  }

  private felt(name: string, strength: number): TakeRequest & { layer?: Layer } {
    const was = this.session.layer;
    const edits = was.edits.filter((edit) => edit.kind !== 'intensity' || (edit.emotion !== name && this.others.some((other) => other.startsWith(edit.emotion))));
    return { emotion: this.asked(name, strength), ...(edits.length === was.edits.length ? {} : { layer: { ...was, edits } }) };
  }

  private asked(name: string, strength: number): string[] {
    return [...(name === '' ? [] : name === 'auto' ? ['auto'] : [`${name}:${strength}`]), ...this.others];
  }

  private request(): TakeRequest {
    return {
      text: this.text.value,
      emotion: this.asked(this.emotions.chosen, this.emotions.amount),
      performer: this.performer.value,
      ...this.manner.request,
      prosody: Number(this.prosody.value),
      seed: Number(this.seed.value),
      fps: this.fps.value,
      ...(this.voice.value === '' || this.recording !== undefined || this.recorded ? {} : { voice: this.voice.value }),
      ...(this.language.value === '' ? {} : { language: this.language.value }),
      ...(this.model.value === '' ? {} : { speech_model: this.model.value }),
    };
  }

  private clear(): void { for (const name of FIELDS) showFault(name, null); }

  async perform(anew = false): Promise<boolean> {
    this.clear();
    const question = this.text.question();
    if (question !== null) showFault('text', question);
    const { session } = this;
    const request = this.request();
    if (session.take === undefined || anew) {
      return this.withGrid(session.perform(request, this.recording, true));
    }
    const spoken = request.text !== session.request.text || this.recording !== undefined || session.take.from_sound !== this.recorded;
    const gone = session.take.from_sound === true && !this.recorded && this.recording === undefined;
    const changes = { voice: null, language: null, speech_model: null, ...request, ...(spoken ? { times: null } : {}), ...(gone ? { sound: null } : {}) };
    return this.withGrid(session.perform(this.recording === undefined ? changes : request, this.recording));
  }

  /** After a performance of a new recording: the times of its TextGrid. */
  private async withGrid(performed: Promise<boolean>): Promise<boolean> {
    const { grid } = this;
    const done = await performed;
    if (done && grid !== undefined) return this.session.takeGrid(grid);
    return done;
  }

  /** Performs the open take again as the controls have it now. */
  private async again(): Promise<boolean> { return this.session.take === undefined ? false : this.perform(); }

  /** The eyes somewhere from the beginning of the line on. */
  private look(target: string): void {
    this.text.value = withGaze(this.text.value, target);
    this.manner.look(this.text.value);
    this.changed();
    void this.again();
  }

  /** Has the server speak what is written while one is still writing. */
  private ahead(): void {
    const { session } = this;
    if (session.working || this.recording !== undefined || this.recorded || this.text.value.trim() === '' || this.text.unfinished) return;
    void api.ahead({ ...session.request, voice: null, language: null, speech_model: null, times: null, ...this.request() });
  }

  /** Takes words and phones from a TextGrid: for the recording that is chosen, or for the take that is open. */
  async useGrid(file: File): Promise<void> {
    showFault('sound', null);
    const { session } = this;
    if (this.recording !== undefined) {
      this.grid = file;
      this.tellSound();
    } else if (session.take !== undefined) await session.takeGrid(file);
    else showFault('sound', `${file.name}: a TextGrid belongs to a recording; drop that first`);
  }

  /** What is written but not performed, for the state of the page. */
  get draft(): Record<string, unknown> { return { ...this.request() }; }

  set draft(draft: Record<string, unknown>) { if (typeof draft['text'] === 'string') this.text.value = draft['text']; }
}

/** The field of the text, whose control lies over its coloured mirror. */
function textField(text: LineText): HTMLElement {
  const whole = field('Text', 'text', text.input);
  text.input.replaceWith(text.element);
  text.element.append(text.input);
  whole.append(text.help);
  return whole;
}
