/** Workers that decode meshes and texture tiles. All streams of the page share them. */

export interface WorkerSetup {
  compiled: WebAssembly.Module;
}
export interface WorkerJob {
  job: Uint8Array<ArrayBuffer>;
}
/** `result` is empty if the worker could not decode the job. */
export interface WorkerResult {
  result: Uint8Array<ArrayBuffer>;
}

type Done = (result: Uint8Array) => void;

/** Jobs per worker that are taken from the core ahead of time, so that no worker waits for a frame. */
const kJobsPerWorker = 3;
const kMostWorkers = 4;

interface DecodeWorker {
  thread: Worker;
  done: Done | null; // function of the job in progress; null if idle
}

export class DecodePool {
  private workers: DecodeWorker[] = [];
  private queue: { job: Uint8Array<ArrayBuffer>; done: Done }[] = [];

  constructor(private readonly compiled: WebAssembly.Module) {
    const cores = navigator.hardwareConcurrency || 2;
    const count = Math.max(1, Math.min(kMostWorkers, cores - 1));
    for (let i = 0; i < count; ++i) this.workers.push(this.makeWorker());
  }

  /** True if another job may be added: the queue is bounded, so that the newest requests come first. */
  get hasRoom(): boolean {
    const running = this.workers.filter((worker) => worker.done).length;
    return this.queue.length + running < this.workers.length * kJobsPerWorker;
  }

  /** Decodes a job. Calls `done` later with the result, which is empty if a worker failed. */
  run(job: Uint8Array<ArrayBuffer>, done: Done): void {
    this.queue.push({ job, done });
    this.dispatch();
  }

  private dispatch(): void {
    for (const worker of this.workers) {
      if (worker.done) continue;
      const next = this.queue.shift();
      if (!next) return;
      worker.done = next.done;
      const message: WorkerJob = { job: next.job };
      worker.thread.postMessage(message, [next.job.buffer]);
    }
  }

  private makeWorker(): DecodeWorker {
    const thread = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    const worker: DecodeWorker = { thread, done: null };
    thread.onmessage = (event: MessageEvent<WorkerResult>) => this.finish(worker, event.data.result);
    thread.onerror = () => {
      // A worker that ran out of memory is of no use any more.
      thread.terminate();
      const index = this.workers.indexOf(worker);
      if (index >= 0 && worker.done) this.workers[index] = this.makeWorker();
      this.finish(worker, new Uint8Array());
    };
    const setup: WorkerSetup = { compiled: this.compiled };
    thread.postMessage(setup);
    return worker;
  }

  private finish(worker: DecodeWorker, result: Uint8Array): void {
    const done = worker.done;
    worker.done = null;
    this.dispatch();
    done?.(result);
  }
}
