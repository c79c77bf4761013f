// The studio's page, put together.
import * as api from './api';
import { button, make, options, showFault } from './dom';
import { VIEWS, LIGHTINGS } from './looks';
import { EditsPanel } from './panels/edits';
import { ExportPanel } from './panels/export';
import { FacePanel } from './panels/face';
import { LinePanel } from './panels/line';
import { RigPanel } from './panels/rig';
import { Playback } from './playback';
import { Session } from './session';
import { helpDialog, listenToKeys } from './shortcuts';
import { Stage } from './stage';
import { Timeline } from './timeline/timeline';
import { Tabs } from './tabs';
import { transport } from './transport';
import './style.css';

/** For benchmarks and tests: how long pictures take, and what is shown. */
interface Stats {
  /** Milliseconds from picture to picture while the face plays, and of work for each on the page's thread. */
  summary: Stage['times']['summary'];
  reset: () => void;
  intervals: readonly number[];
  work: readonly number[];
  /** The take and the frames that are shown. */
  shown: () => { take: string; seconds: number; channels: readonly string[]; values: Float32Array } | null;
  /** What the first mesh with such a morph target stands at. */
  influence: (target: string) => number | undefined;
  /** The face under the tree in the deformation editor: parts' vertices one after the other, mm, and the parameter's values. */
  tree: () => { rig: string; values: Record<string, number>; vertices: Float32Array[] } | null;
}

declare global {
  interface Window { mienStats: Stats }
}

async function start(): Promise<void> {
  const session = new Session(await api.about());
  const playback = new Playback();
  const canvas = make('canvas', { 'aria-label': 'The face', role: 'img' });
  const backdrop = make('div', { class: 'backdrop' }, canvas);
  const stage = new Stage(canvas, backdrop);
  const timeline = new Timeline(session, playback);
  const help = helpDialog();

  const lights = make('select', { 'aria-label': 'Light', id: 'light' });
  options(lights, Object.keys(LIGHTINGS).map((name): [string, string] => [name, `light: ${name}`]), 'portrait');
  lights.addEventListener('change', () => stage.light(lights.value));
  const views = make('select', { 'aria-label': 'Camera', id: 'camera' });
  options(views, Object.keys(VIEWS).map((name): [string, string] => [name, `camera: ${name}`]), 'portrait');
  const view = (name: string): void => { views.value = name; stage.view(name); };
  views.addEventListener('change', () => view(views.value));

  let rig: RigPanel | undefined;
  const show = (): void => {
    if (rig?.active === true) stage.touch();
    else if (session.clip !== undefined) stage.pose(session.clip.channels, session.clip.sample(playback.now));
    else stage.touch();
  };
  const line = new LinePanel(session);
  const face = new FacePanel(session, stage, show);
  const before = { id: '' };
  rig = new RigPanel(session, stage, async () => {
    before.id = face.id;
    if (face.id !== session.about.default_face) await face.show(session.about.default_face);
  }, () => {
    if (before.id !== session.about.default_face) void face.show(before.id);
    show();
  });
  const files = new ExportPanel(session, () => ({ face: face.id, light: lights.value, camera: views.value }));
  const tabs = new Tabs([
    ['line', 'Line', line.element], ['edits', 'Edits', new EditsPanel(session).element],
    ['export', 'Export', files.element], ['face', 'Face', face.element],
    ['rig', 'Rig', rig.element],
  ], timeline.element, (name) => {
    if (name === 'rig') void rig?.show();
    else if (name !== 'timeline') rig?.hide();
  });

  const told = make('div', { class: 'told', role: 'status', 'aria-live': 'polite' });
  const toast = make('p', { class: 'toast', role: 'alert', hidden: true });
  const stageArea = make('section', { id: 'stage', 'aria-label': 'Face' }, backdrop, make('div', { class: 'looks' }, views, lights), told, toast);
  document.body.append(make('main', {}, make('h1', { class: 'visually-hidden' }, 'mien studio'), stageArea, tabs.element, transport(playback, session, () => help.showModal()), timeline.element, help));

  session.on('frames', show);
  playback.on('time', show);
  session.on('take', ({ take, fresh }) => {
    if (!fresh || session.sound === undefined) return;
    playback.load(session.sound, take.seconds, take.fps);
    void decoded(session.sound).then((sound) => timeline.setSound(sound.getChannelData(0), sound.sampleRate));
  });
  session.on('busy', (job) => {
    told.replaceChildren(...(job === null ? [] : [
      make('span', {}, `${job.step || job.state} …`), make('progress', { max: 1, ...(job.done ? { value: job.done } : {}) }),
      button('Cancel', () => session.stopWork(), { class: 'small' })]));
  });
  let hiding = 0;
  session.on('problem', ({ message, field }) => {
    if (field !== null && showFault(field, message)) tabs.reveal(field);
    else toast.textContent = message;
    toast.hidden = field !== null && document.getElementById(`fault-${field}`) !== null;
    clearTimeout(hiding);
    hiding = window.setTimeout(() => { toast.hidden = true; }, 12_000);
  });
  listenToKeys({ playback, session, timeline, help: () => help.showModal(), view: (place) => view(Object.keys(VIEWS)[place] ?? 'portrait') });
  dropFiles(line, face, tabs);

  const { times } = stage;
  window.mienStats = { summary: () => times.summary(), reset: () => times.reset(), intervals: times.intervals, work: times.work,
    shown: () => (session.clip === undefined ? null : { take: session.take?.take ?? '', seconds: playback.now, channels: session.clip.channels, values: session.clip.values }),
    influence: (target) => stage.influence(target),
    tree: () => (rig?.editor === undefined ? null : { rig: rig.id, values: Object.fromEntries(rig.editor.values), vertices: rig.editor.vertices() }) };
  const tick = (): void => {
    playback.tick();
    stage.draw(playback.playing);
    requestAnimationFrame(tick);
  };
  tick();
  await face.show(session.about.default_face).catch((problem: unknown) => session.tell(problem));
  document.body.dataset['ready'] = 'true';
}

async function decoded(wav: ArrayBuffer): Promise<AudioBuffer> {
  return new OfflineAudioContext(1, 1, 48_000).decodeAudioData(wav.slice(0));
}

/** Sounds and faces may be dropped anywhere. */
function dropFiles(line: LinePanel, face: FacePanel, tabs: Tabs): void {
  document.addEventListener('dragover', (event) => {
    event.preventDefault();
    document.body.classList.add('dropping');
  });
  document.addEventListener('dragleave', (event) => { if (event.relatedTarget === null) document.body.classList.remove('dropping'); });
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    const file = event.dataTransfer?.files[0];
    if (file === undefined) return;
    if (/\.(glb|vrm)$/i.test(file.name)) {
      tabs.choose('face');
      void face.upload(file);
    } else {
      tabs.choose('line');
      line.useSound(file);
    }
  });
}

start().catch((problem: unknown) => {
  document.body.append(make('p', { class: 'broken', role: 'alert' }, problem instanceof Error ? problem.message : String(problem)));
});
