// What is said, by whom, in which mood: a new line, or the same one again with its edits.
import { button, field, make, options, showFault } from '../dom';
import type { Session } from '../session';
import type { TakeRequest } from '../types';

const EXAMPLE = 'I never said that. Maybe five people heard my voice!';
const DROP = 'or drop a sound file here';
const FIELDS = ['text', 'sound', 'emotion', 'voice', 'language', 'performer', 'speech_model', 'effort', 'prosody', 'seed', 'fps'];

export class LinePanel {
  readonly element = make('form', { class: 'panel', id: 'panel-line', 'aria-label': 'Line' });
  private readonly text = make('textarea', { rows: 3, spellcheck: true, placeholder: 'What shall be said?' });
  private readonly file = make('input', { type: 'file', accept: 'audio/*,.wav,.flac,.mp3,.ogg', class: 'visually-hidden' });
  private readonly fileName = make('span', { class: 'file-name' });
  private readonly noSound = button('Remove the recording', () => this.useSound(undefined), { class: 'small', hidden: true }, '×');
  private readonly emotion = make('select');
  private readonly strength = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 0.7, 'aria-label': 'Intensity of the emotion' });
  private readonly strengthText = make('output', {}, '70 %');
  private readonly voice = make('select');
  private readonly language = make('select');
  private readonly performer = make('select');
  private readonly model = make('select');
  private readonly effort = make('input', { type: 'text', value: 'auto', spellcheck: false, title: '0 to 2, 1 as recorded; auto: as a recording sounds; off; or points such as 0.5@0,1.6@2' });
  private readonly prosody = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 0.5 });
  private readonly seed = make('input', { type: 'number', min: 0, step: 1, value: 0, inputmode: 'numeric' });
  private readonly fps = make('input', { type: 'number', min: 1, max: 240, step: 1, value: 60, inputmode: 'numeric' });
  private readonly again = button('Redo, keep edits', () => void this.redo(), { disabled: true, id: 'redo-line', title: 'Perform this take again with what is set here; the edits are laid over it again' });
  private recording: File | undefined;

  constructor(private readonly session: Session) {
    this.text.value = EXAMPLE;
    this.fileName.textContent = DROP;
    this.fill();
    const drop = make('div', { class: 'drop' }, make('label', { class: 'button', for: 'field-sound' }, 'Recording …'), this.file, this.fileName, this.noSound);
    const more = make('details', { class: 'more' }, make('summary', {}, 'Voice, performer and more'),
      field('Voice', 'voice', this.voice), field('Language', 'language', this.language), field('Performer', 'performer', this.performer),
      field('Speech model', 'speech_model', this.model), field('Effort (0 to 2, auto or off)', 'effort', this.effort),
      field('Brows and nods on accents', 'prosody', this.prosody),
      make('div', { class: 'pair' }, field('Seed', 'seed', this.seed), field('Frames per second', 'fps', this.fps)));
    const soundField = make('div', { class: 'field', 'data-field': 'sound' }, drop, make('p', { class: 'fault', id: 'fault-sound', role: 'alert', hidden: true }));
    this.file.id = 'field-sound';
    // A browser cannot point at a faulty number in a section that is shut, and would do nothing at all.
    more.addEventListener('invalid', () => { more.open = true; }, true);
    this.element.append(
      field('Text', 'text', this.text), soundField,
      field('Emotion', 'emotion', this.emotion), make('div', { class: 'strength' }, this.strength, this.strengthText),
      more, make('div', { class: 'actions' }, make('button', { type: 'submit', class: 'primary', id: 'perform' }, 'Perform'), this.again));
    this.listen();
  }

  private fill(): void {
    const { about } = this.session;
    const plain = (names: string[]): [string, string][] => names.map((name) => [name, name]);
    options(this.voice, [['', 'default'], ...about.voices.map(({ name, language }): [string, string] => [name, `${name} (${language})`])]);
    options(this.language, [['', 'from the text'], ...plain(about.languages)]);
    options(this.performer, plain(about.performers));
    options(this.model, [['', 'default'], ...plain(about.speech_models)]);
    this.fillEmotions();
  }

  private fillEmotions(): void {
    const names = this.session.about.emotions.filter((name) => name !== 'neutral');
    const heard: [string, string][] = this.recording === undefined ? [] : [['auto', 'as the voice sounds']];
    options(this.emotion, [['', 'neutral'], ...heard, ...names.map((name): [string, string] => [name, name])], this.emotion.value);
    this.strength.disabled = this.emotion.value === '' || this.emotion.value === 'auto';
  }

  private listen(): void {
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.perform();
    });
    this.text.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || event.shiftKey) return;
      event.preventDefault();
      void this.perform();
    });
    this.emotion.addEventListener('change', () => this.fillEmotions());
    this.strength.addEventListener('input', () => { this.strengthText.textContent = `${Math.round(Number(this.strength.value) * 100)} %`; });
    this.file.addEventListener('change', () => this.useSound(this.file.files?.[0]));
    this.session.on('take', ({ fresh }) => { if (fresh) this.again.disabled = false; });
    this.session.on('busy', (job) => { for (const press of this.element.querySelectorAll<HTMLButtonElement>('.actions button')) press.disabled = job !== null || (press === this.again && this.session.take === undefined); });
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
    this.file.value = '';
    this.fileName.textContent = file?.name ?? DROP;
    this.noSound.hidden = file === undefined;
    this.text.placeholder = file === undefined ? 'What shall be said?' : 'What is said in the recording? Empty: it is recognised.';
    if (file !== undefined && this.text.value === EXAMPLE) this.text.value = '';
    this.voice.disabled = file !== undefined;
    this.fillEmotions();
  }

  private asked(): TakeRequest {
    const emotion = this.emotion.value;
    return {
      text: this.text.value,
      emotion: emotion === '' ? [] : emotion === 'auto' ? ['auto'] : [`${emotion}:${this.strength.value}`],
      performer: this.performer.value,
      effort: this.effort.value.trim() || 'auto',
      prosody: Number(this.prosody.value),
      seed: Number(this.seed.value),
      fps: this.fps.value,
      ...(this.voice.value === '' || this.recording !== undefined ? {} : { voice: this.voice.value }),
      ...(this.language.value === '' ? {} : { language: this.language.value }),
      ...(this.model.value === '' ? {} : { speech_model: this.model.value }),
    };
  }

  private clear(): void { for (const name of FIELDS) showFault(name, null); }

  async perform(): Promise<void> {
    this.clear();
    await this.session.perform(this.asked(), this.recording);
  }

  private async redo(): Promise<void> {
    this.clear();
    await this.session.redo({ voice: null, language: null, speech_model: null, ...this.asked() });
  }
}
