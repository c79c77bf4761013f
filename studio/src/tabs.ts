// The panels beside the face; on a narrow screen the timeline is one of them.
import { make } from './dom';

export class Tabs {
  readonly element: HTMLElement;
  private readonly tabs = new Map<string, { tab: HTMLButtonElement; panel: HTMLElement }>();

  constructor(
    panels: readonly (readonly [string, string, HTMLElement])[], timeline: HTMLElement, private readonly told: (name: string) => void,
  ) {
    const list = make('div', { role: 'tablist', class: 'tablist', 'aria-label': 'Panels' });
    const wrapped = panels.map(([name, label, content]) => {
      const panel = make('div', { role: 'tabpanel', id: `tab-panel-${name}`, class: 'tabpanel' }, content);
      this.add(list, name, label, panel);
      return panel;
    });
    this.add(list, 'timeline', 'Timeline', timeline);
    list.addEventListener('keydown', (event) => this.press(event));
    this.element = make('aside', { id: 'side', 'aria-label': 'Panels' }, list, ...wrapped);
    this.choose('line');
  }

  private add(list: HTMLElement, name: string, label: string, panel: HTMLElement): void {
    const tab = make('button', { type: 'button', role: 'tab', id: `tab-${name}`, 'aria-controls': panel.id, class: `for-${name}` }, label);
    panel.setAttribute('aria-labelledby', tab.id);
    tab.addEventListener('click', () => this.choose(name));
    list.append(tab);
    this.tabs.set(name, { tab, panel });
  }

  choose(name: string): void {
    for (const [other, { tab, panel }] of this.tabs) {
      tab.setAttribute('aria-selected', String(other === name));
      tab.tabIndex = other === name ? 0 : -1;
      panel.classList.toggle('chosen', other === name);
    }
    document.body.dataset['tab'] = name;
    this.told(name);
  }

  /** Shows the panel in which a field is. */
  reveal(field: string): void {
    for (const [name, { panel }] of this.tabs) {
      const fault = panel.querySelector(`#fault-${CSS.escape(field)}`);
      if (fault === null) continue;
      this.choose(name);
      const details = fault.closest('details');
      if (details !== null) details.open = true;
      fault.scrollIntoView({ block: 'nearest' });
    }
  }

  private press(event: KeyboardEvent): void {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    const names = [...this.tabs].filter(([, { tab }]) => tab.offsetParent !== null).map(([name]) => name);
    const next = names[(names.indexOf(document.body.dataset['tab'] ?? '') + step + names.length) % names.length];
    if (next === undefined) return;
    this.choose(next);
    this.tabs.get(next)?.tab.focus();
  }
}
