// The border between face and timeline: dragged, or moved with arrows.
import { make } from './dom';

const LEAST = 140; // px

export function split(main: HTMLElement, lower: HTMLElement, changed: () => void): { element: HTMLElement; height: () => number | undefined; set: (height: number) => void } {
  const element = make('div', { class: 'splitter', role: 'separator', tabindex: 0, 'aria-orientation': 'horizontal', 'aria-label': 'Height of the timeline', 'aria-valuemin': LEAST, 'aria-valuenow': LEAST, title: 'Drag to make the timeline taller' });
  let asked: number | undefined; // what somebody chose, whatever a smaller screen makes of it
  const set = (height: number): void => {
    asked = Math.round(height);
    const most = Math.max(main.clientHeight - 230, LEAST);
    const kept = Math.round(Math.min(Math.max(height, LEAST), most));
    main.style.setProperty('--timeline', `${kept}px`);
    element.setAttribute('aria-valuenow', String(kept));
    element.setAttribute('aria-valuemax', String(most));
    changed();
  };
  element.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    const [from, height] = [event.clientY, lower.clientHeight];
    element.setPointerCapture(event.pointerId);
    const move = (to: PointerEvent): void => set(height + from - to.clientY);
    element.addEventListener('pointermove', move);
    element.addEventListener('pointerup', () => element.removeEventListener('pointermove', move), { once: true });
  });
  element.addEventListener('keydown', (event) => {
    const step = { ArrowUp: 24, ArrowDown: -24 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    set(lower.clientHeight + step);
  });
  new ResizeObserver(() => element.setAttribute('aria-valuenow', String(lower.clientHeight))).observe(lower);
  return { element, height: () => asked, set };
}
