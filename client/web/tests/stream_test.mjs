import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Stream } from "../page/stream.ts";

let sockets = [];
class FakeSocket {
  static OPEN = 1;
  readyState = 0;
  sent = [];
  constructor(url) {
    this.url = url;
    sockets.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen();
  }
  receive(...bytes) {
    this.onmessage({ data: new Uint8Array(bytes).buffer });
  }
  send(bytes) {
    this.sent.push([...bytes]);
  }
  close() {
    this.readyState = 3;
  }
}

/** A core that answers each received byte, and takes no more while an answer is not sent. */
class FakeModel {
  isOpen = true;
  wants = true;
  connected = false;
  received = [];
  outgoing = [];
  ended = null;
  wantsConnection = () => this.wants;
  isConnected = () => this.connected;
  connect = () => ((this.wants = false), (this.connected = true));
  disconnect = (why) => ((this.why = why), (this.connected = false), null);
  step = () => this.ended;
  takesInput = () => this.outgoing.length === 0;
  receive = (bytes) => {
    assert.ok(this.takesInput());
    this.received.push(...bytes);
    this.outgoing.push(...bytes);
    return null;
  };
  takeOutgoing = () => (this.outgoing.length > 0 ? new Uint8Array(this.outgoing.splice(0)) : null);
  takeJob = () => null;
  takeCacheQuery = () => null;
  takeArrival = () => null;
}

const makeStream = (model) => new Stream(model, { hasRoom: true }, { get: async () => null });

beforeEach(() => {
  sockets = [];
  globalThis.WebSocket = FakeSocket;
  globalThis.window = { setTimeout: () => 0 };
  globalThis.document = { baseURI: "https://host/prefix/t/a%20b/?embed#model=m" };
});

test("the socket is beside the folder of tokens", () => {
  makeStream(new FakeModel()).pump();
  assert.equal(sockets[0].url, "wss://host/prefix/ws");
});

test("received bytes reach the core in order, and its answers are sent in between", () => {
  const model = new FakeModel();
  makeStream(model).pump();
  sockets[0].open();
  sockets[0].receive(1, 2);
  sockets[0].receive(3);
  assert.deepEqual(model.received, [1, 2, 3]);
  assert.deepEqual(sockets[0].sent, [[1, 2], [3]]);
});

test("a lost connection is reported, and replaced when the core asks for one", () => {
  const model = new FakeModel();
  const stream = makeStream(model);
  stream.pump();
  sockets[0].open();
  sockets[0].onclose({ reason: "" });
  assert.match(model.why, /lost/);
  assert.match(stream.trouble, /lost/);
  stream.pump();
  assert.equal(sockets.length, 1);
  model.wants = true;
  stream.pump();
  sockets[1].open();
  assert.equal(stream.trouble, "");
});

test("attempts that fail are repeated after a wait, and the core learns nothing of them", () => {
  const model = new FakeModel();
  const stream = makeStream(model);
  let now = 1000;
  globalThis.performance = { now: () => now };
  Math.random = () => 0;
  stream.pump();
  sockets[0].onclose({ reason: "" });
  assert.equal(model.why, undefined);
  assert.match(stream.trouble, /does not answer/);
  stream.pump();
  assert.equal(sockets.length, 1);
  now += 500;
  stream.pump();
  assert.equal(sockets.length, 2);
  sockets[1].onclose({ reason: "" });
  now += 999;
  stream.pump();
  assert.equal(sockets.length, 2);
});

test("the socket is closed when the core has ended the connection", () => {
  const model = new FakeModel();
  const stream = makeStream(model);
  stream.pump();
  sockets[0].open();
  model.connected = false;
  stream.pump();
  assert.equal(sockets[0].readyState, 3);
});

test("a stream that has ended for good opens no socket and takes no bytes", () => {
  const model = new FakeModel();
  const stream = makeStream(model);
  stream.pump();
  sockets[0].open();
  model.ended = "the server has no such model";
  model.wants = true;
  stream.pump();
  sockets[0].receive(1);
  stream.pump();
  assert.equal(stream.failure, "the server has no such model");
  assert.equal(sockets.length, 1);
  assert.deepEqual(model.received, []);
});
