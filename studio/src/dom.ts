// Elements, made in one call each.
type Attributes = Record<string, string | number | boolean | undefined>;
export type Child = Node | string | null | undefined;

/** An element with attributes (`class`, `aria-...`; true is an empty attribute, false and undefined none) and children. */
export function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag, attributes: Attributes = {}, ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? '' : String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

export function button(label: string, press: () => void, attributes: Attributes = {}, ...children: Child[]): HTMLButtonElement {
  const element = make('button', { type: 'button', ...attributes }, ...(children.length > 0 ? children : [label]));
  if (children.length > 0) {
    element.setAttribute('aria-label', label);
    element.title = String(attributes['title'] ?? label);
  }
  element.addEventListener('click', press);
  return element;
}

/** A field with its label, and room below for what is wrong with it. */
export function field(label: string, name: string, control: HTMLElement, help?: string): HTMLElement {
  control.id = `field-${name}`;
  const fault = make('p', { class: 'fault', id: `fault-${name}`, role: 'alert', hidden: true });
  control.setAttribute('aria-describedby', `fault-${name}`);
  return make('div', { class: 'field', 'data-field': name },
    make('label', { for: control.id }, label), control, help === undefined ? null : make('p', { class: 'help' }, help), fault);
}

/** What of the page helps with a fault of a field, and what that is called. */
const HELP: Readonly<Record<string, readonly [id: string, label: string]>> = { text: ['tag-help', 'What can stand in a text'] };

function openHelp(id: string): void {
  const help = document.getElementById(id);
  if (help instanceof HTMLDetailsElement) help.open = true;
  help?.scrollIntoView({ block: 'nearest' });
}

/** Shows a fault at its field; `false` if there is no such field to be seen. */
export function showFault(name: string, message: string | null): boolean {
  const fault = document.getElementById(`fault-${name}`);
  if (fault === null) return false;
  fault.replaceChildren(message ?? '', ...(message === null || HELP[name] === undefined ? [] : [' ', button(HELP[name][1], () => openHelp(HELP[name]?.[0] ?? ''), { class: 'small' })]));
  fault.hidden = message === null;
  document.getElementById(`field-${name}`)?.toggleAttribute('aria-invalid', message !== null);
  return true;
}

export function options(select: HTMLSelectElement, values: readonly (readonly [string, string])[], chosen = ''): void {
  select.replaceChildren(...values.map(([value, label]) => make('option', { value, selected: value === chosen }, label)));
}

/** A picture drawn with lines on a 16 x 16 grid. */
export function icon(path: string, filled = false): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  for (const [name, value] of Object.entries({ viewBox: '0 0 16 16', width: '16', height: '16', 'aria-hidden': 'true' })) svg.setAttribute(name, value);
  const line = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  line.setAttribute('d', path);
  line.setAttribute('fill', filled ? 'currentColor' : 'none');
  if (!filled) for (const [name, value] of Object.entries({ stroke: 'currentColor', 'stroke-width': '1.5', 'stroke-linecap': 'round', 'stroke-linejoin': 'round' })) line.setAttribute(name, value);
  svg.append(line);
  return svg;
}

export const ICONS = {
  play: 'M4 2.5v11l9-5.5z', pause: 'M4 3h3v10H4zM9 3h3v10H9z', back: 'M9.5 3 4.5 8l5 5M13 3v10', on: 'M6.5 3l5 5-5 5M3 3v10',
  start: 'M12.5 3 7 8l5.5 5M3.5 3v10', loop: 'M4 5h7a3 3 0 0 1 3 3M12 11H5a3 3 0 0 1-3-3M6 2.5 3.5 5 6 7.500M10 8.500 12.500 11 10 13.500',
  undo: 'M6 3 3 6l3 3M3 6h6a4 4 0 0 1 0 8H6', redo: 'M10 3l3 3-3 3M13 6H7a4 4 0 0 0 0 8h3', plus: 'M8 3v10M3 8h10', minus: 'M3 8h10',
  spectrum: 'M3 13V9M6 13V4M9 13V7M12 13V10', tall: 'M8 2v12M5 5l3-3 3 3M5 11l3 3 3-3',
  live: 'M8 9.500v4M8 7.500a1 1 0 1 0 .01 0M5 10.500a4 4 0 0 1 0-5.500M11 10.500a4 4 0 0 0 0-5.500M3 12.500a7 7 0 0 1 0-9.500M13 12.500a7 7 0 0 0 0-9.500', fit: 'M2 8h12M5 5 2 8l3 3M11 5l3 3-3 3', cross: 'M4 4l8 8M12 4l-8 8', save: 'M8 2v8M4.500 7 8 10.500 11.500 7M3 13.500h10', help: 'M6 6a2 2 0 1 1 3 1.700c-.7.4-1 .8-1 1.600M8 12v.1',
} as const;

export function download(name: string, content: BlobPart, type: string): void {
  const address = URL.createObjectURL(new Blob([content], { type }));
  make('a', { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
