// Which channels are shown: a list by the part of the face, with a filter.
import { make } from '../dom';
import type { ChannelFacts } from '../types';

export class ChannelMenu {
  readonly element: HTMLElement;
  private readonly boxes = new Map<string, HTMLInputElement>();

  constructor(facts: readonly ChannelFacts[], first: readonly string[], private readonly changed: () => void) {
    const groups = new Map<string, ChannelFacts[]>();
    for (const fact of facts) groups.set(fact.group, [...(groups.get(fact.group) ?? []), fact]);
    const filter = make('input', { type: 'search', placeholder: 'filter', 'aria-label': 'Filter channels' });
    const lists = [...groups].map(([group, members]) => make('fieldset', {}, make('legend', {}, group), ...members.map((fact) => this.box(fact, first)), this.pairs(members)));
    filter.addEventListener('input', () => {
      for (const [name, box] of this.boxes) (box.closest('label') as HTMLElement).hidden = !name.toLowerCase().includes(filter.value.toLowerCase());
      for (const list of lists) list.hidden = [...list.querySelectorAll('label')].every((label) => label.hidden);
    });
    const panel = make('div', { class: 'menu' }, filter, make('div', { class: 'groups' }, ...lists));
    const details = make('details', { class: 'channels' }, make('summary', { class: 'small' }, 'channels'), panel);
    details.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape' || !details.open) return;
      event.stopPropagation();
      details.open = false;
      details.querySelector('summary')?.focus();
    });
    document.addEventListener('pointerdown', (event) => { if (!details.contains(event.target as Node)) details.open = false; });
    this.element = details;
  }

  get chosen(): string[] {
    return [...this.boxes].filter(([, box]) => box.checked).map(([name]) => name);
  }

  /** Shows exactly these. */
  choose(names: readonly string[]): void {
    for (const [name, box] of this.boxes) box.checked = names.includes(name);
    this.changed();
  }

  toggle(name: string, shown: boolean): void {
    const box = this.boxes.get(name);
    if (box === undefined || box.checked === shown) return;
    box.checked = shown;
    this.changed();
  }

  /** Both sides of the face at once. */
  private pairs(members: readonly ChannelFacts[]): HTMLElement | null {
    const sided = members.filter(({ name }) => /Left$/.test(name)).map(({ name }) => name);
    if (sided.length === 0) return null;
    const press = make('button', { type: 'button', class: 'small' }, 'both sides of those shown');
    press.addEventListener('click', () => {
      for (const name of sided) {
        const boxes = [this.boxes.get(name), this.boxes.get(name.replace(/Left$/, 'Right'))];
        if (boxes.some((box) => box?.checked === true)) for (const box of boxes) if (box !== undefined) box.checked = true;
      }
      this.changed();
    });
    return press;
  }

  private box({ name }: ChannelFacts, first: readonly string[]): HTMLElement {
    const box = make('input', { type: 'checkbox', checked: first.includes(name) });
    box.addEventListener('change', () => this.changed());
    this.boxes.set(name, box);
    return make('label', {}, box, name);
  }
}
