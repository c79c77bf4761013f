// The text of a line: tags in colour, those that can be written offered as one types, and [happy] understood or questioned.
import { button, make } from '../dom';

/** What can stand in a text, and what it does: the beginning of docs/script.md. */
const OFFERED: readonly (readonly [string, string])[] = [
  ['<pause seconds="0.5"/>', 'half a second of silence'], ['<HeadNod/>', 'a nod at the next word'], ['<HeadShake/>', 'the head shaken'],
  ['<Smile>', 'a smile over words'], ['<BrowRaise/>', 'brows up'], ['<Blink/>', 'a blink'], ['<WinkLeft/>', 'a wink'],
  ['<gaze target="left"/>', 'eyes to the left from here on'], ['<gaze target="right"/>', 'eyes to the right'], ['<gaze target="camera"/>', 'eyes to the camera'],
  ['<effort level="1.5">…</effort>', 'words articulated harder (0 to 2)'], ['<emphasis level="strong">…</emphasis>', 'slower and louder'],
];
const TAG = /<\/?[A-Za-z][^<>\n]*>?|\[[^\][\n]{1,40}\]?/g;

/** The text with emotions in square brackets as tags: `[happy] Yes` holds to the end or to the next. */
export function withTags(text: string, emotions: readonly string[]): { text: string; unknown: string[] } {
  const unknown: string[] = [];
  const told = text.replace(/\[\s*([A-Za-z]{2,24})(?:[ :]+([\d.]+))?\s*\]/g, (whole, name: string, strength?: string) => {
    const word = name.toLowerCase();
    if (word === 'pause' || word === 'beat') return '<pause seconds="0.4"/>';
    const emotion = emotions.find((one) => one === word) ?? emotions.find((one) => word.length > 3 && one.slice(0, 4) === word.slice(0, 4));
    if (emotion !== undefined) return `<${emotion}${strength === undefined ? '' : ` ${strength}`}>`;
    unknown.push(name);
    return whole;
  });
  return { text: told, unknown };
}

export class LineText {
  readonly input = make('textarea', { rows: 3, spellcheck: true });
  readonly help = make('div', { class: 'tags' });
  readonly element: HTMLElement;
  private readonly mirror = make('div', { class: 'mirror', 'aria-hidden': 'true' });
  private readonly offers = make('div', { class: 'offers', role: 'group', 'aria-label': 'Tags' });

  constructor(private readonly emotions: readonly string[], perform: () => void) {
    this.element = make('div', { class: 'text-field' }, this.mirror, this.input);
    const rows = OFFERED.flatMap(([tag, what]) => [make('dt', {}, make('code', {}, tag)), make('dd', {}, what)]);
    const list = make('details', { class: 'tag-help', id: 'tag-help' }, make('summary', {}, 'What can stand in a text'), make('dl', {},
      make('dt', {}, make('code', {}, '[happy]')), make('dd', {}, `an emotion from here on: ${emotions.filter((name) => name !== 'neutral').join(', ')}; [happy 0.5] is weaker`), ...rows));
    this.help.append(this.offers, list);
    this.input.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || event.shiftKey || event.isComposing) return;
      event.preventDefault();
      perform();
    });
    for (const name of ['input', 'click', 'keyup'] as const) this.input.addEventListener(name, () => this.paint());
    this.input.addEventListener('scroll', () => { this.mirror.scrollTop = this.input.scrollTop; });
    this.paint();
  }

  /** As it is sent. */
  get value(): string { return withTags(this.input.value, this.emotions).text; }
  set value(text: string) {
    this.input.value = text;
    this.paint();
  }

  /** Whether a tag is being written. */
  get unfinished(): boolean { return /[<[][^>\]]*$/.test(this.input.value); }

  /** What is not understood in the text, as a question. */
  question(): string | null {
    const { unknown } = withTags(this.input.value, this.emotions);
    return unknown.length === 0 ? null : `Is [${unknown[0]}] to be read aloud? No emotion is called so; known are ${this.emotions.filter((name) => name !== 'neutral').join(', ')}.`;
  }

  private paint(): void {
    const { value } = this.input;
    const pieces: (Node | string)[] = [];
    let last = 0;
    for (const match of value.matchAll(TAG)) {
      const bracket = match[0].startsWith('[');
      const known = bracket ? withTags(match[0], this.emotions).unknown.length === 0 && match[0].endsWith(']') : match[0].endsWith('>');
      pieces.push(value.slice(last, match.index), make('mark', { class: known ? 'tag' : 'tag open' }, match[0]));
      last = match.index + match[0].length;
    }
    this.mirror.replaceChildren(...pieces, value.slice(last), '\n');
    this.offer();
  }

  /** Tags that fit what is being typed; else the most usual. */
  private offer(): void {
    const { value, selectionStart: caret } = this.input;
    const typed = /[<[]([A-Za-z]*)$/.exec(value.slice(0, caret));
    const moods = this.emotions.filter((name) => name !== 'neutral').map((name): [string, string] => [`[${name}]`, `${name} from here on`]);
    const all = [...(typed?.[0].startsWith('<') === true ? [] : moods), ...OFFERED];
    const word = (typed?.[1] ?? '').toLowerCase();
    const found = typed === null ? [] : all.filter(([tag]) => tag.slice(1).toLowerCase().startsWith(word)).slice(0, 8);
    this.offers.replaceChildren(...found.map(([tag, what]) => button(tag, () => this.insert(tag, typed?.[0].length ?? 0), { class: 'small', title: what })));
  }

  private insert(tag: string, typed: number): void {
    const { selectionStart: caret } = this.input;
    const [opening, closing = ''] = tag.split('…');
    const written = closing === '' ? `${tag} ` : `${opening}${closing}`;
    this.input.setRangeText(written, caret - typed, caret, 'end');
    this.input.focus();
    const at = caret - typed + (closing === '' ? written.length : (opening as string).length);
    this.input.setSelectionRange(at, at); // between the two, to write what is in them
    this.input.dispatchEvent(new Event('input', { bubbles: true }));
  }
}
