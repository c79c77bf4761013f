// The server, as functions. Every failure is an ApiError with one line for the person and the field it concerns.
import type { FoldData } from './folds';
import type { PartShape } from './rig/editor';
import type { Influences, TreeData } from './rig/tree';
import type { About, History, Job, Layer, Listed, Take, TakeRequest } from './types';

export class ApiError extends Error {
  constructor(message: string, readonly field: string | null = null, readonly status = 0) {
    super(message);
  }
}

/** The "status" where no answer came at all. */
export const GONE = -1;

async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, init);
  } catch {
    throw new ApiError('The studio does not answer: start "mien studio" again; what you did is kept here until then.', null, GONE);
  }
  if (answer.ok) return answer;
  const told = await answer.json().catch(() => ({})) as { error?: string; field?: string | null };
  throw new ApiError(told.error ?? `The studio answered ${answer.status} ${answer.statusText}`, told.field ?? null, answer.status);
}

const json = (method: string, content: unknown): RequestInit =>
  ({ method, headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(content) });
const read = async <T>(path: string, init?: RequestInit): Promise<T> => (await ask(path, init)).json() as Promise<T>;

export const about = (): Promise<About> => read('/api/about');
export const take = (id: string): Promise<Take> => read(`/api/takes/${id}`);
export const soundAddress = (id: string): string => `/api/takes/${id}/sound.wav`;
export const sound = async (id: string): Promise<ArrayBuffer> => (await ask(soundAddress(id))).arrayBuffer();

/** Frames x channels; without the edits of channels (`plain`), or without any emotion (`neutral`). */
export async function frames(id: string, kind: 'plain' | 'neutral' | 'edited', revision: number): Promise<Float32Array> {
  const query = kind === 'edited' ? '' : `&${kind}=1`;
  const bytes = await (await ask(`/api/takes/${id}/frames?revision=${revision}${query}`)).arrayBuffer();
  return new Float32Array(bytes);
}

export async function face(id: string): Promise<ArrayBuffer> {
  return (await ask(`/api/faces/${id}.glb`)).arrayBuffer();
}

/** The folds of a face's skin; null where it has none. */
export async function folds(id: string): Promise<FoldData | null> {
  const told = await read<FoldData | Record<string, never>>(`/api/faces/${id}/folds`);
  return 'folds' in told ? told as FoldData : null;
}

export interface ListedFace { face: string; name: string; own: boolean; picture?: boolean; report?: unknown }
export const faces = async (): Promise<ListedFace[]> => (await read<{ faces: ListedFace[] }>('/api/faces')).faces;
export interface Head { head: string; name: string; vertices: Float32Array; triangles: Uint32Array; landmarks: Record<string, { place: [number, number, number]; words: string }> }
const bytes = (packed: string): ArrayBuffer => Uint8Array.from(atob(packed), (sign) => sign.charCodeAt(0)).buffer;
export const openHead = async (file: File): Promise<string> =>
  (await read<{ job: string }>(`/api/heads?name=${encodeURIComponent(file.name)}`, { method: 'POST', headers: { 'Content-Type': 'model/gltf-binary' }, body: file })).job;
export async function head(id: string): Promise<Head> {
  const told = await read<Omit<Head, 'vertices' | 'triangles'> & { vertices: string; triangles: string }>(`/api/heads/${id}`);
  return { ...told, vertices: new Float32Array(bytes(told.vertices)), triangles: new Uint32Array(bytes(told.triangles)) };
}
export const fitHead = async (id: string, landmarks: Record<string, number[]>): Promise<string> =>
  (await read<{ job: string }>(`/api/heads/${id}/fit`, json('POST', { landmarks }))).job;

/** The small picture that the page has drawn of a face of one's own. */
export const keepPicture = (id: string, picture: Blob): Promise<unknown> =>
  read(`/api/faces/${id}.jpg`, { method: 'PUT', headers: { 'Content-Type': 'image/jpeg' }, body: picture });

export const addFace = (file: Blob, name: string): Promise<{ face: string; report: unknown }> =>
  read(`/api/faces?name=${encodeURIComponent(name)}`, { method: 'POST', headers: { 'Content-Type': 'model/gltf-binary' }, body: file });

function filled(request: TakeRequest, recording: File): FormData {
  const form = new FormData();
  for (const [name, value] of Object.entries(request)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== undefined && one !== null && one !== '' && typeof one !== 'object') form.append(name, String(one));
    }
  }
  form.append('sound', recording, recording.name);
  return form;
}

const asked = (request: TakeRequest, recording?: File): RequestInit =>
  (recording === undefined ? json('POST', request) : { method: 'POST', body: filled(request, recording) });

export const startTake = async (request: TakeRequest, recording?: File): Promise<string> =>
  (await read<{ job: string }>('/api/takes', asked(request, recording))).job;

/** The next step of a take: some fields changed, another layer, another sound, or none any more (`sound: null`). */
export const redo = async (id: string, changed: TakeRequest & { layer?: Layer; sound?: null }, recording?: File): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/redo`, asked(changed, recording))).job;

/** The line with some fields changed, to be heard and seen only: a job whose take is there until the next trial is. */
export const trial = async (id: string, changed: TakeRequest & { layer?: Layer }): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/trial`, asked(changed))).job;

/** Has the server make ready what is being written; whether it does is its own affair. */
export const ahead = (request: TakeRequest): Promise<unknown> => read('/api/ahead', json('POST', request)).catch(() => undefined);

/** The words and phones of a TextGrid for a take: a job. */
export const textGrid = async (id: string, file: Blob): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/textgrid`, { method: 'POST', headers: { 'Content-Type': 'text/plain' }, body: file })).job;

export interface PageShows { take: string; at: number; speed: number; loop: [number, number] | null }
export interface Live { sending: boolean; kind?: string; to?: string; kinds: Record<string, number> }
export const live = (): Promise<Live> => read('/api/live');
export const startLive = (asked: PageShows & { kind: string; to: string; subject: string }): Promise<Live> => read('/api/live', json('POST', asked));
export const showLive = (shown: PageShows): Promise<unknown> => read('/api/live', json('PUT', shown));
export const stopLive = (): Promise<Live> => read('/api/live', { method: 'DELETE' });

export const takes = async (): Promise<Listed[]> => (await read<{ takes: Listed[] }>('/api/takes')).takes;
export const openTake = async (id: string): Promise<string> => (await read<{ job: string }>(`/api/takes/${id}/open`, { method: 'POST' })).job;
export const copyTake = async (id: string): Promise<string> => (await read<{ take: string }>(`/api/takes/${id}/copy`, { method: 'POST' })).take;
export const renameTake = (id: string, name: string): Promise<{ name: string }> => read(`/api/takes/${id}/name`, json('PUT', { name }));
export const dropTake = (id: string): Promise<unknown> => read(`/api/takes/${id}`, { method: 'DELETE' });
export const history = (id: string): Promise<History> => read(`/api/takes/${id}/steps`);
export interface StepsChanged { keep: number; add: Layer[]; at: number; count: number }
export const putSteps = (id: string, steps: StepsChanged): Promise<{ revision?: number; take?: Take; job?: string }> =>
  read(`/api/takes/${id}/steps`, json('PUT', steps));

/** Gives a take to a server that does not know it. */
export async function handBack(id: string, record: History, sound: ArrayBuffer | undefined): Promise<string> {
  const form = new FormData();
  form.append('take', id);
  form.append('record', JSON.stringify(record));
  if (sound !== undefined && record.steps.some((step) => step.sound !== null)) form.append('sound', new Blob([sound], { type: 'audio/wav' }), 'take.wav');
  return (await read<{ take: string }>('/api/takes/back', { method: 'POST', body: form })).take;
}

export const page = (): Promise<Record<string, unknown>> => read('/api/page');
export const putPage = (state: unknown): Promise<unknown> => read('/api/page', json('PUT', state));
/** As `putPage`, from a page that is being closed. */
export const sendPage = (state: unknown): boolean => navigator.sendBeacon('/api/page', new Blob([JSON.stringify(state)], { type: 'application/json' }));
export const projectAddress = '/api/project';
export const openProject = (file: Blob): Promise<{ takes: Record<string, string>; faces: Record<string, string>; page: Record<string, unknown> }> =>
  read('/api/project', { method: 'POST', headers: { 'Content-Type': 'application/zip' }, body: file });
export interface Expressions { channels: string[]; emotions: Record<string, number[]> }
export const expressions = (performer: string): Promise<Expressions> => read(`/api/expressions?performer=${encodeURIComponent(performer)}`);

export interface ExportRequest { formats: string[]; face?: string; camera?: string; light?: string }
export const startExport = async (id: string, asked: ExportRequest): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/export`, json('POST', asked))).job;

export interface RigFault { line?: number | null; parameter?: string | null; text: string }
export const getRig = (id: string): Promise<{ config: TreeData; face: string }> => read(`/api/rigs/${id}`);
export async function getRigMesh(id: string): Promise<PartShape[]> {
  const { parts } = await read<{ parts: { name: string; vertices: string; triangles: string }[] }>(`/api/rigs/${id}/mesh`);
  return parts.map(({ name, vertices, triangles }) => ({ name, vertices: new Float32Array(bytes(vertices)), triangles: new Uint32Array(bytes(triangles)) }));
}
export const getInfluences = (id: string): Promise<Influences> => read(`/api/rigs/${id}/influence`);
export const addRig = (text: string, face: string): Promise<{ rig: string }> => read(`/api/rigs?face=${encodeURIComponent(face)}`, { method: 'POST', headers: { 'Content-Type': 'text/plain' }, body: text });
export const checkRig = (config: TreeData, face: string): Promise<{ ok: boolean; faults: RigFault[] }> => read('/api/rigs/check', json('POST', { config, face }));
export const putRig = (id: string, config: TreeData): Promise<{ rig: string }> => read(`/api/rigs/${id}`, json('PUT', { config }));
export const rigText = async (id: string): Promise<string> => (await ask(`/api/rigs/${id}.txt`)).text();

/** Waits for a job, telling how far it is; a signal cancels it on the server too. */
export async function finished(id: string, tell: (job: Job) => void, signal?: AbortSignal): Promise<Job> {
  for (;;) {
    if (signal?.aborted === true) {
      await ask(`/api/jobs/${id}`, { method: 'DELETE' });
      throw new ApiError('Cancelled.');
    }
    const job = await read<Job>(`/api/jobs/${id}?wait=4`);
    tell(job);
    if (job.state === 'done') return job;
    if (job.state === 'failed' || job.state === 'cancelled') {
      throw new ApiError(job.error ?? (job.state === 'cancelled' ? 'Cancelled.' : 'It failed.'), job.field ?? null);
    }
  }
}
