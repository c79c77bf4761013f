// The server, as functions. Every failure is an ApiError with one line for the person and the field it concerns.
import type { PartPlace } from './rig/editor';
import type { Influences, TreeData } from './rig/tree';
import type { About, Job, Layer, Lost, Take, TakeRequest } from './types';

export class ApiError extends Error {
  constructor(message: string, readonly field: string | null = null, readonly status = 0) {
    super(message);
  }
}

const POLL_MS = 150;

async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, init);
  } catch {
    throw new ApiError('The studio does not answer: does "mien studio" still run?');
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

export const addFace = (file: Blob): Promise<{ face: string; report: unknown }> =>
  read('/api/faces', { method: 'POST', headers: { 'Content-Type': 'model/gltf-binary' }, body: file });

export async function startTake(request: TakeRequest, recording?: File): Promise<string> {
  if (recording === undefined) return (await read<{ job: string }>('/api/takes', json('POST', request))).job;
  const form = new FormData();
  for (const [name, value] of Object.entries(request)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== undefined && one !== null && one !== '') form.append(name, String(one));
    }
  }
  form.append('sound', recording, recording.name);
  return (await read<{ job: string }>('/api/takes', { method: 'POST', body: form })).job;
}

export const redo = async (id: string, changed: TakeRequest): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/redo`, json('POST', changed))).job;

export interface ExportRequest { formats: string[]; face?: string; camera?: string; light?: string }
export const startExport = async (id: string, asked: ExportRequest): Promise<string> =>
  (await read<{ job: string }>(`/api/takes/${id}/export`, json('POST', asked))).job;

export const putEdits = (id: string, layer: Layer): Promise<{ revision: number; lost?: Lost[]; take?: Take }> =>
  read(`/api/takes/${id}/edits`, json('PUT', layer));
export interface RigFault { line?: number | null; parameter?: string | null; text: string }
export const getRig = (id: string): Promise<{ config: TreeData; parts: PartPlace[] }> => read(`/api/rigs/${id}`);
export const getInfluences = (id: string): Promise<Influences> => read(`/api/rigs/${id}/influence`);
export const addRig = (text: string): Promise<{ rig: string }> => read('/api/rigs', { method: 'POST', headers: { 'Content-Type': 'text/plain' }, body: text });
export const checkRig = (config: TreeData): Promise<{ ok: boolean; faults: RigFault[] }> => read('/api/rigs/check', json('POST', { config }));
export const putRig = (id: string, config: TreeData): Promise<{ rig: string }> => read(`/api/rigs/${id}`, json('PUT', { config }));
export const rigText = async (id: string): Promise<string> => (await ask(`/api/rigs/${id}.txt`)).text();

/** Waits for a job, telling how far it is; a signal cancels it on the server too. */
export async function finished(id: string, tell: (job: Job) => void, signal?: AbortSignal): Promise<Job> {
  for (;;) {
    if (signal?.aborted === true) {
      await ask(`/api/jobs/${id}`, { method: 'DELETE' });
      throw new ApiError('Cancelled.');
    }
    const job = await read<Job>(`/api/jobs/${id}`);
    tell(job);
    if (job.state === 'done') return job;
    if (job.state === 'failed' || job.state === 'cancelled') {
      throw new ApiError(job.error ?? (job.state === 'cancelled' ? 'Cancelled.' : 'It failed.'), job.field ?? null);
    }
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
}
