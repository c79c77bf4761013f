// A menu at the pointer, or at the element that has the focus.
import { make } from '../dom';

/** A row of choices, of which one may be in force. */
export interface Choices { label: string; choices: readonly { name: string; title: string; pressed: boolean; act: () => void }[] }
export type Item = readonly [label: string, act: () => void, keys?: string] | Choices | null;

let open: HTMLElement | undefined;

export function closeMenu(): void {
  open?.remove();
  open = undefined;
}

export function showMenu(x: number, y: number, items: readonly Item[]): void {
  closeMenu();
  const back = document.activeElement as HTMLElement | null;
  const menu = make('div', { class: 'context-menu', role: 'menu', tabindex: -1 }, ...items.map((item) => {
    if (item === null) return make('hr', { role: 'separator' });
    const press = (entry: HTMLButtonElement, act: () => void): HTMLButtonElement => {
      entry.addEventListener('click', () => {
        closeMenu();
        back?.focus({ preventScroll: true });
        act();
      });
      return entry;
    };
    if ('choices' in item) {
      return make('div', { class: 'choices', role: 'group', 'aria-label': item.label }, make('span', {}, item.label), make('div', {}, ...item.choices.map(({ name, title, pressed, act }) =>
        press(make('button', { type: 'button', role: 'menuitemradio', tabindex: -1, title, 'aria-checked': String(pressed) }, name), act))));
    }
    const [label, act, keys] = item;
    return press(make('button', { type: 'button', role: 'menuitem', tabindex: -1 }, make('span', {}, label), keys === undefined ? null : make('kbd', {}, keys)), act);
  }));
  menu.addEventListener('keydown', (event) => {
    const entries = [...menu.querySelectorAll<HTMLElement>('[role^=menuitem]')];
    const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.key];
    if (event.key === 'Escape' || event.key === 'Tab') {
      closeMenu();
      back?.focus({ preventScroll: true });
    } else if (step !== undefined) entries[(entries.indexOf(document.activeElement as HTMLElement) + step + entries.length) % entries.length]?.focus();
    else if (event.key !== 'Enter' && event.key !== ' ') return;
    if (event.key !== 'Enter' && event.key !== ' ') event.preventDefault();
    event.stopPropagation();
  });
  document.body.append(menu);
  open = menu;
  const { width, height } = menu.getBoundingClientRect();
  menu.style.left = `${Math.max(4, Math.min(x, innerWidth - width - 4))}px`;
  menu.style.top = `${Math.max(4, Math.min(y, innerHeight - height - 4))}px`;
  menu.querySelector<HTMLElement>('[role=menuitem]')?.focus({ preventScroll: true });
}

document.addEventListener('pointerdown', (event) => { if (open !== undefined && !open.contains(event.target as Node)) closeMenu(); }, { capture: true });

/** Asks for one line; null if nothing was given. `choices`: values that can be pressed instead, each with what it means. */
export function ask(title: string, value: string, choices: readonly (readonly [string, string])[] = []): Promise<string | null> {
  const input = make('input', { type: 'text', value, 'aria-label': title });
  const grid = choices.map(([choice, meaning]) => {
    const press = make('button', { type: 'button', class: 'small', 'aria-pressed': String(choice === value) }, make('b', {}, choice), ` ${meaning}`);
    press.addEventListener('click', () => { input.value = choice; dialog.close('yes'); });
    return press;
  });
  const form = make('form', { method: 'dialog' }, make('h2', {}, title), input, choices.length === 0 ? null : make('div', { class: 'choices' }, ...grid),
    make('div', { class: 'actions' }, make('button', { value: 'no' }, 'Cancel'), make('button', { value: 'yes', class: 'primary' }, 'OK')));
  const dialog = make('dialog', { class: 'help-dialog', 'aria-label': title }, form);
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    event.preventDefault();
    dialog.close('yes');
  });
  document.body.append(dialog);
  dialog.showModal();
  input.select();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      dialog.remove();
      resolve(dialog.returnValue === 'yes' && input.value.trim() !== '' ? input.value.trim() : null);
    });
  });
}
