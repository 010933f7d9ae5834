import type { BlobCache } from "./blob_cache";
import type { CoreModel } from "./core_model";
import type { DecodePool } from "./decode_pool";
import { socketUrl } from "./server";

/** Time after which a connection attempt fails, and the stream tries again. */
const kConnectDeadlineMs = 15_000;
/** Wait after a failed attempt, at first and at most. It doubles with each. */
const kFirstWaitMs = 500;
const kLongestWaitMs = 15_000;
/** Largest number of open cache queries. */
const kMostQueries = 16;
const kDecoderStopped =
  "a part of the model cannot be decoded, maybe because memory ran out; close other tabs, or choose a smaller memory limit";

/**
 * Connects a model of the core to its server, the decode workers and the cache. Call pump() once per frame;
 * it also runs when a message or result arrives. Calls `arrived` when the core has taken a message.
 */
export class Stream {
  private socket: WebSocket | null = null;
  private deadline = 0;
  private wait_ms = kFirstWaitMs;
  private next_attempt_ms = 0;
  private queries = 0;
  private waiting: Uint8Array[] = []; // received bytes that the core does not take yet
  private ended: string | null = null;
  private trouble_ = "";
  private changed_ = false;

  constructor(
    private readonly model: CoreModel,
    private readonly pool: DecodePool,
    private readonly cache: BlobCache,
    private readonly arrived: () => void = () => {},
  ) {}

  /** The reason why the stream has ended for good, or null. */
  get failure(): string | null {
    return this.ended;
  }

  /** The reason why there is no connection while the core tries again, or "". */
  get trouble(): string {
    return this.trouble_;
  }

  /** Returns true if something arrived since the last call. */
  takeChanged(): boolean {
    const changed = this.changed_;
    this.changed_ = false;
    return changed;
  }

  pump(): void {
    if (this.ended !== null || !this.model.isOpen) return;
    const now = performance.now();
    this.fail(this.model.step(now));
    this.check();
    const may_connect = this.ended === null && !this.socket && now >= this.next_attempt_ms;
    if (may_connect && this.model.wantsConnection(now)) this.connect();
    this.send();
    this.passInput();
    this.passJobs();
    this.passQueries();
    this.passArrivals();
  }

  close(): void {
    this.ended ??= "closed";
    this.drop();
  }

  private connect(): void {
    const socket = new WebSocket(socketUrl());
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.deadline = window.setTimeout(() => this.lose(socket, ""), kConnectDeadlineMs);
    socket.onopen = () => {
      clearTimeout(this.deadline);
      if (this.socket !== socket) return;
      this.trouble_ = "";
      this.wait_ms = kFirstWaitMs;
      this.model.connect(performance.now());
      this.pump();
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => this.receive(socket, new Uint8Array(event.data));
    socket.onclose = (event) => this.lose(socket, event.reason);
  }

  private receive(socket: WebSocket, bytes: Uint8Array): void {
    if (this.socket !== socket || this.ended !== null) return;
    this.changed_ = true;
    this.waiting.push(bytes);
    this.pump();
    this.arrived();
  }

  /** Passes received bytes to the core, which accepts none while its own bytes wait to be sent. */
  private passInput(): void {
    let is_blocked = !this.model.takesInput();
    while (this.socket && this.ended === null && (is_blocked || this.waiting.length > 0)) {
      this.send();
      if (!this.model.takesInput()) return;
      const bytes = is_blocked ? new Uint8Array() : (this.waiting.shift() ?? new Uint8Array());
      this.fail(this.model.receive(bytes, performance.now()));
      this.check();
      is_blocked = !this.model.takesInput();
    }
    this.send();
  }

  /** Closes the socket if the core has ended the connection, or must reconnect because the server shuts down. */
  private check(): void {
    const socket = this.socket;
    if (this.ended !== null || socket?.readyState !== WebSocket.OPEN) return;
    if (!this.model.isConnected()) this.drop();
    else if (this.model.wantsConnection(performance.now())) this.lose(socket, "the server asks to connect again");
  }

  /** Reports a lost connection to the core. Failed attempts are repeated and not reported. */
  private lose(socket: WebSocket, reason: string): void {
    if (this.socket !== socket) return;
    this.drop();
    this.changed_ = true;
    const now = performance.now();
    if (this.model.isOpen && this.model.isConnected()) {
      this.trouble_ = reason || "the connection to the server is lost";
      this.fail(this.model.disconnect(this.trouble_, now));
      return;
    }
    this.trouble_ = reason || "the server does not answer";
    this.next_attempt_ms = now + this.wait_ms * (1 + Math.random() / 2); // spreads reconnections
    this.wait_ms = Math.min(kLongestWaitMs, this.wait_ms * 2);
  }

  /** Closes the socket without telling the core. */
  private drop(): void {
    clearTimeout(this.deadline);
    const socket = this.socket;
    this.socket = null;
    this.waiting = [];
    socket?.close();
  }

  private fail(error: string | null): void {
    if (error === null) return;
    this.ended = error;
    this.changed_ = true;
    this.drop();
  }

  private send(): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    for (let bytes = this.model.takeOutgoing(); bytes; bytes = this.model.takeOutgoing()) this.socket.send(bytes);
  }

  private passJobs(): void {
    while (this.pool.hasRoom) {
      const job = this.model.takeJob();
      if (!job) return;
      this.pool.run(job, (result) => {
        if (!this.model.isOpen) return;
        this.changed_ = true;
        this.fail(result ? this.model.finishJob(result) : kDecoderStopped);
        this.pump();
      });
    }
  }

  private passQueries(): void {
    while (this.queries < kMostQueries) {
      const query = this.model.takeCacheQuery();
      if (!query) return;
      ++this.queries;
      void this.cache.get(query.digest).then((blob) => {
        --this.queries;
        if (!this.model.isOpen) return;
        this.changed_ = true;
        this.model.finishCacheQuery(query.number, blob);
        this.pump();
      });
    }
  }

  private passArrivals(): void {
    for (let blob = this.model.takeArrival(); blob; blob = this.model.takeArrival())
      void this.cache.put(blob.digest, blob.bytes);
  }
}
