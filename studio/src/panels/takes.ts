// All takes that the studio keeps: open, rename, duplicate, delete, compare; the project as one file.
import * as api from '../api';
import { button, icon, ICONS, make } from '../dom';
import type { Session } from '../session';
import type { Listed } from '../types';

export class TakesPanel {
  readonly element = make('div', { class: 'panel', id: 'panel-takes' });
  private readonly list = make('ul', { class: 'takes', 'aria-label': 'Takes' });
  private readonly file = make('input', { type: 'file', accept: '.mienproject,.zip', class: 'visually-hidden', id: 'field-project' });
  compared = '';

  /** @param compare shows another take beside the open one (`''`: none); `opened` takes the state of a project's page */
  constructor(private readonly session: Session, private readonly compare: (take: string) => void, private readonly opened: (page: Record<string, unknown>) => void) {
    this.element.append(
      make('p', { class: 'help' }, 'Everything you do is kept as you do it, and is here when you come back.'), this.list,
      make('div', { class: 'actions' },
        make('a', { class: 'button', href: api.projectAddress, download: 'takes.mienproject', id: 'save-project' }, 'Save all as one file'),
        make('label', { class: 'button', for: 'field-project' }, 'Open a project …'), this.file),
      make('p', { class: 'fault', id: 'fault-project', role: 'alert', hidden: true }));
    this.file.addEventListener('change', () => void this.openProject(this.file.files?.[0]));
    session.on('list', () => void this.refresh());
    session.on('take', ({ fresh }) => { if (fresh) void this.refresh(); });
    void this.refresh();
  }

  async refresh(): Promise<void> {
    const takes = await api.takes().catch(() => undefined);
    if (takes === undefined || this.list.contains(document.activeElement?.closest('li input') ?? null)) return;
    if (!takes.some(({ take }) => take === this.compared)) this.compared = '';
    this.list.replaceChildren(...(takes.length === 0 ? [make('li', { class: 'quiet' }, 'None yet: write a line and perform it.')] : takes.map((one) => this.row(one))));
  }

  private row({ take, name, text, emotion, edits, from_sound: recorded }: Listed): HTMLElement {
    const open = take === this.session.take?.take;
    const facts = [recorded ? 'recording' : '', ...emotion, edits > 0 ? `${edits} ${edits === 1 ? 'edit' : 'edits'}` : ''].filter((fact) => fact !== '').join(', ');
    const press = button(name, () => { location.hash = `take=${take}`; }, { class: 'take-name', 'aria-current': open ? 'true' : undefined, title: text });
    const row = make('li', { class: `take${open ? ' open' : ''}`, 'data-take': take });
    const rename = (): void => {
      const input = make('input', { type: 'text', value: name, 'aria-label': `New name of ${name}`, maxlength: 200 });
      const done = async (): Promise<void> => {
        input.removeEventListener('blur', finish);
        if (input.value.trim() !== '' && input.value !== name) await api.renameTake(take, input.value).catch((problem: unknown) => this.session.tell(problem));
        input.blur();
        await this.refresh();
      };
      const finish = (): void => void done();
      input.addEventListener('blur', finish);
      input.addEventListener('keydown', (event) => {
        if (event.key === 'Enter') finish();
        if (event.key === 'Escape') { input.value = name; finish(); }
        event.stopPropagation();
      });
      press.replaceWith(input);
      input.focus();
      input.select();
    };
    row.append(press, make('span', { class: 'take-facts' }, facts), make('div', { class: 'take-actions' },
      button('Rename', rename, { class: 'small', 'aria-label': `Rename ${name}` }),
      button('Duplicate', () => void this.duplicate(take), { class: 'small', 'aria-label': `Duplicate ${name}` }),
      open ? null : button('Compare', () => this.choose(take), { class: 'small', 'aria-label': `Compare with ${name}`, 'aria-pressed': String(this.compared === take) }),
      make('a', { class: 'button small', href: `${api.projectAddress}?take=${take}`, download: `${name}.mienproject`, 'aria-label': `Save ${name} as a file` }, 'Save'),
      button(`Delete ${name}`, () => void this.remove(take, name), { class: 'small' }, icon(ICONS.cross))));
    return row;
  }

  private choose(take: string): void {
    this.compared = this.compared === take ? '' : take;
    this.compare(this.compared);
    void this.refresh();
  }

  private async duplicate(take: string): Promise<void> {
    try {
      location.hash = `take=${await api.copyTake(take)}`;
    } catch (problem) {
      this.session.tell(problem);
    }
    await this.refresh();
  }

  private async remove(take: string, name: string): Promise<void> {
    if (!window.confirm(`Delete “${name}”? Its file moves to the folder “deleted” of the studio.`)) return;
    try {
      await api.dropTake(take);
      if (take === this.session.take?.take) {
        this.session.leave();
        history.replaceState(null, '', location.pathname + location.search);
      }
    } catch (problem) {
      this.session.tell(problem);
    }
    await this.refresh();
  }

  async openProject(file: File | undefined): Promise<void> {
    this.file.value = '';
    if (file === undefined) return;
    let first: string | undefined;
    await this.session.work(async () => {
      const { takes, page } = await api.openProject(file);
      first = takes[String(page['take'] ?? '')] ?? Object.values(takes)[0];
      this.opened(page);
    });
    await this.refresh();
    if (first !== undefined) location.hash = `take=${first}`;
  }
}
