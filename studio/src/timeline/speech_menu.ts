// What can be done with a word or a phone, in a menu.
import type { Session } from '../session';
import type { Span } from '../types';
import { ask, type Item } from './context_menu';
import { inserted, isPause, joined, removed, renamed, split, timesOf } from './speech_editing';

/** The sounds of English as ARPAbet writes them, and a word that has each. */
const PHONES: readonly (readonly [string, string])[] = (
  'AA father|AE cat|AH cut|AO law|AW cow|AY eye|EH bed|ER bird|EY day|IH sit|IY see|OW go|OY boy|UH book|UW two|B bee|CH chin|D day|DH then|F fee|G go|HH he|JH joy|' +
  'K key|L lay|M me|N no|NG sing|P pea|R read|S sea|SH she|T tea|TH thin|V vow|W we|Y yes|Z zoo|ZH vision|SIL pause'
).split('|').map((one) => one.split(' ') as [string, string]);

export class SpeechMenu {
  private readonly tier: readonly Span[];

  constructor(private readonly session: Session, private readonly kind: 'words' | 'phones', private readonly at: number, private readonly loop: (loop: [number, number]) => void) {
    this.tier = session.take?.[kind] ?? [];
  }

  items(): Item[] {
    const { tier, at } = this;
    const place = tier.findIndex(([begin, end]) => at >= begin && at < end);
    const here = tier[place];
    const what = this.kind === 'words' ? 'word' : 'phone';
    const name = here === undefined ? '' : isPause(here[2]) ? 'pause' : here[2];
    const next = tier[place + 1];
    return [
      ...(here === undefined ? [] : ([
        [`Rename “${name}” …`, () => void this.rename(place, here)], [`Split “${name}” here …`, () => void this.split(place, here)],
        ...(next === undefined ? [] : [[`Join with “${isPause(next[2]) ? 'pause' : next[2]}”`, (): void => this.keep(joined(tier, place, this.kind === 'words' ? `${here[2]}${next[2]}` : isPause(here[2]) ? next[2] : here[2]))] as const]),
        ...(this.kind === 'phones' && isPause(here[2]) ? [] : [[this.kind === 'phones' ? 'Make it a pause' : 'Remove the word', (): void => this.keep(removed(tier, place, this.kind === 'phones'))] as const]),
        [`Loop this ${what}`, () => this.loop([here[0], here[1]])],
      ] satisfies (readonly [string, () => void])[] as Item[])),
      ...(here === undefined && this.kind === 'words' ? [['Insert a word here …', () => void this.insert()] as Item] : []),
      ...(this.session.request.times ? [null, ['As it was found, without corrections', () => void this.session.perform({ times: null })] as Item] : []),
    ];
  }

  /** Asks what the word or the sound at this moment is. */
  correct(): void {
    const place = this.tier.findIndex(([begin, end]) => this.at >= begin && this.at < end);
    if (place >= 0) void this.rename(place, this.tier[place] as Span);
  }

  private async rename(place: number, [, , label]: Span): Promise<void> {
    const given = await (this.kind === 'words' ? ask('What is the word?', label) : ask('Which sound is it?', label, PHONES));
    if (given !== null) this.keep(renamed(this.tier, place, this.kind === 'phones' ? given.toUpperCase() : given));
  }

  private async split(place: number, [, , label]: Span): Promise<void> {
    const given = await ask('The two parts, with a blank between', `${label} ${label}`);
    const [first, second] = given?.split(/\s+/) ?? [];
    if (first === undefined || second === undefined) return;
    const labels: [string, string] = this.kind === 'phones' ? [first.toUpperCase(), second.toUpperCase()] : [first, second];
    this.keep(split(this.tier, place, this.at, labels));
  }

  private async insert(): Promise<void> {
    const given = await ask('Which word?', '');
    if (given !== null) this.keep(inserted(this.tier, this.at, given, this.session.take?.seconds ?? this.at));
  }

  private keep(tier: Span[]): void {
    const { take } = this.session;
    if (take === undefined) return;
    void this.session.perform({ times: this.kind === 'words' ? timesOf(tier, take.phones) : timesOf(take.words, tier) });
  }
}
