/** Workers that decode meshes and texture tiles. All streams of the page share them. */

export interface WorkerSetup {
  compiled: WebAssembly.Module;
}
export interface WorkerJob {
  job: Uint8Array;
}
/** Message of a worker. `result` is null if the worker could not decode the job. */
export interface WorkerResult {
  result: Uint8Array<ArrayBuffer> | null;
}

/** A job in the queue or at a worker. */
interface PooledJob {
  job: Uint8Array;
  done: (result: Uint8Array | null) => void;
  has_failed: boolean;
}

interface DecodeWorker {
  thread: Worker | null; // null if the last thread failed; the next job starts a new thread
  running: PooledJob | null;
}

const kMostWorkers = 4;
/** Jobs per worker that are taken from the core ahead of time, so that no worker waits for a frame. */
const kJobsPerWorker = 3;

export class DecodePool {
  private readonly workers: DecodeWorker[] = [];
  private readonly queue: PooledJob[] = [];

  constructor(private readonly compiled: WebAssembly.Module) {
    const cores = navigator.hardwareConcurrency || 2;
    const count = Math.max(1, Math.min(kMostWorkers, cores - 1));
    for (let i = 0; i < count; ++i) {
      const worker = { thread: null, running: null };
      this.start(worker);
      this.workers.push(worker);
    }
  }

  /** True if another job may be added: the queue is bounded, so that the newest requests come first. */
  get hasRoom(): boolean {
    const running = this.workers.filter((worker) => worker.running).length;
    return this.queue.length + running < this.workers.length * kJobsPerWorker;
  }

  /** Decodes a job. Calls `done` later with the result, or with null if two workers have failed. */
  run(job: Uint8Array, done: (result: Uint8Array | null) => void): void {
    this.queue.push({ job, done, has_failed: false });
    this.dispatch();
  }

  private dispatch(): void {
    for (const worker of this.workers) {
      if (worker.running) continue;
      const next = this.queue.shift();
      if (!next) return;
      worker.running = next;
      const message: WorkerJob = { job: next.job };
      (worker.thread ?? this.start(worker)).postMessage(message);
    }
  }

  /** Gives a worker a thread of its own. */
  private start(worker: DecodeWorker): Worker {
    const thread = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    worker.thread = thread;
    thread.onmessage = (event: MessageEvent<WorkerResult>) => {
      if (event.data.result) this.finish(worker, event.data.result);
      else this.abandon(worker);
    };
    thread.onerror = () => this.abandon(worker);
    const setup: WorkerSetup = { compiled: this.compiled };
    thread.postMessage(setup);
    return thread;
  }

  /** Ends a thread that has failed, for example because memory ran out, and tries its job once more. */
  private abandon(worker: DecodeWorker): void {
    worker.thread?.terminate();
    worker.thread = null;
    const job = worker.running;
    if (!job) return;
    if (job.has_failed) {
      this.finish(worker, null);
      return;
    }
    job.has_failed = true;
    worker.running = null;
    this.queue.unshift(job);
    this.dispatch();
  }

  private finish(worker: DecodeWorker, result: Uint8Array | null): void {
    const job = worker.running;
    worker.running = null;
    this.dispatch();
    job?.done(result);
  }
}
