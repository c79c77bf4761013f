// What the page looks like, kept by the server as it changes, so that a reload or a second window shows the same.
import * as api from './api';

export interface PageState {
  take?: string; line?: Record<string, unknown>; face?: string; light?: string; camera?: string; tab?: string;
  view?: { first: number; last: number; at: number; loop: [number, number] | null }; channels?: string[]; tall?: string[];
  markers?: Record<string, number[]>; snap?: string; height?: number;
}

const WAIT_MS = 300;

/** Sends what `read` gives whenever `touch` is called, a little later and once for many calls. */
export class PageKeeper {
  private waiting = 0;
  private sent = '';
  /** Nothing is sent before the page looks as it did. */
  ready = false;

  constructor(private readonly read: () => PageState) {
    addEventListener('pagehide', () => this.flush());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.flush(); });
  }

  touch(): void {
    if (!this.ready) return;
    clearTimeout(this.waiting);
    this.waiting = window.setTimeout(() => {
      const state = this.read();
      const content = JSON.stringify(state);
      if (content === this.sent) return;
      this.sent = content;
      void api.putPage(state).catch(() => { this.sent = ''; }); // the next change brings it along
    }, WAIT_MS);
  }

  private flush(): void {
    clearTimeout(this.waiting);
    const state = this.read();
    if (!this.ready || JSON.stringify(state) === this.sent) return;
    this.sent = JSON.stringify(state);
    api.sendPage(state);
  }
}
