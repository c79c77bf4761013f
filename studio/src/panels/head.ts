// A head without shapes: the points that mien found on its face, dragged to where they belong, and the shapes it gets.
import { Box3, BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, Vector3 } from 'three';
import * as api from '../api';
import { button, make, showFault } from '../dom';
import type { Session } from '../session';
import type { Stage } from '../stage';

const NEAR = 16; // px: so near a press takes hold of a point

export class HeadPanel {
  readonly element = make('div', { class: 'head-fit' });
  private readonly steps = make('div', { hidden: true });
  private readonly list = make('ul', { class: 'marks', 'aria-label': 'Points on the face' });
  private head: api.Head | undefined;
  private surface: Mesh | undefined;
  private readonly points = new Map<string, Mesh>();
  private readonly moved = new Set<string>();

  /** @param fitted shows the face that the head has become */
  constructor(private readonly session: Session, private readonly stage: Stage, private readonly fitted: (face: string) => Promise<void>) {
    this.element.append(this.steps);
    this.steps.append(
      make('h3', {}, 'A head without shapes'),
      make('p', { class: 'help' }, 'It cannot move yet, and gets mien’s shapes. You see where its features were found: drag a point that is not where it belongs.'), this.list, make('div', { class: 'actions' },
      button('Back', () => this.leave()), button('Give it shapes', () => void this.fit(), { class: 'primary', id: 'fit-head' })));
    (stage.canvas.parentElement as HTMLElement).addEventListener('pointerdown', (event) => this.grab(event), { capture: true });
  }

  async open(file: File): Promise<void> {
    showFault('face', null);
    await this.session.work(async (signal) => {
      const done = await api.finished(await api.openHead(file), (told) => this.session.emit('busy', told), signal);
      this.show(await api.head(done.head ?? ''));
    });
  }

  private show(head: api.Head): void {
    this.head = head;
    this.moved.clear();
    this.points.clear();
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(head.vertices, 3));
    geometry.setIndex(new BufferAttribute(head.triangles, 1));
    geometry.computeVertexNormals();
    this.surface = new Mesh(geometry, new MeshLambertMaterial({ color: 0xb9b2ac, side: DoubleSide }));
    const [group, box] = [new Group(), new Box3()];
    for (const { place } of Object.values(head.landmarks)) box.expandByPoint(new Vector3(...place));
    const size = box.getSize(new Vector3()).length();
    for (const [name, { place }] of Object.entries(head.landmarks)) {
      const point = new Mesh(new SphereGeometry(size * 0.022, 14, 10), new MeshBasicMaterial({ color: 0xffd24a, depthTest: false, transparent: true }));
      point.position.set(...place);
      point.renderOrder = 10;
      this.points.set(name, point);
    }
    group.add(this.surface, ...this.points.values());
    this.stage.instead(group, box.expandByScalar(size * 0.3));
    this.steps.hidden = false;
    this.tell();
  }

  private tell(): void {
    this.list.replaceChildren(...Object.entries(this.head?.landmarks ?? {}).map(([name, { words }]) =>
      make('li', { class: this.moved.has(name) ? 'moved' : '', title: words }, `${name.replaceAll('_', ' ')}${this.moved.has(name) ? ': moved' : ''}`)));
  }

  /** A point near the pointer is dragged over the surface. */
  private grab(event: PointerEvent): void {
    const { surface, stage } = this;
    if (surface === undefined || event.button !== 0 || !event.isPrimary) return;
    const area = stage.canvas.getBoundingClientRect();
    const apart = (point: Mesh): number => {
      const { x, y } = point.position.clone().project(stage.camera);
      return Math.hypot(((x + 1) / 2) * area.width - (event.clientX - area.left), ((1 - y) / 2) * area.height - (event.clientY - area.top));
    };
    const [name, point] = [...this.points].sort(([, a], [, b]) => apart(a) - apart(b))[0] ?? [];
    if (name === undefined || point === undefined || apart(point) > NEAR) return;
    event.stopPropagation();
    const move = (to: PointerEvent): void => {
      const hit = stage.under(to.clientX - area.left, to.clientY - area.top, [surface]);
      if (hit === undefined) return;
      point.position.copy(hit.point);
      (point.material as MeshBasicMaterial).color.set(0x6fe39a);
      this.moved.add(name);
      stage.touch();
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', () => {
      window.removeEventListener('pointermove', move);
      this.tell();
    }, { once: true });
  }

  private async fit(): Promise<void> {
    const { head } = this;
    if (head === undefined) return;
    showFault('face', null);
    const landmarks = Object.fromEntries([...this.moved].map((name) => [name, (this.points.get(name) as Mesh).position.toArray()]));
    await this.session.work(async (signal) => {
      const done = await api.finished(await api.fitHead(head.head, landmarks), (told) => this.session.emit('busy', told), signal);
      this.leave();
      await this.fitted(done.face ?? '');
    });
  }

  /** The face again. */
  leave(): void {
    if (this.surface === undefined) return;
    this.surface.geometry.dispose();
    this.surface = undefined;
    this.steps.hidden = true;
    this.stage.instead(undefined);
  }
}
