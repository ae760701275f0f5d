// The WebSocket: messages in, commands out, and how our clock stands to the server's. Comes back by
// itself, at once and then ever more slowly, to 2 s.

const kRetryMin_ms = 250, kRetryMax_ms = 2000, kPing_ms = 2000, kPingsKept = 8;

// {type, ...} and, of a binary message, the DataView's bytes behind the JSON.
function decode(data) {
  if (typeof data === 'string') return [JSON.parse(data), null];
  const size = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, size)));
  return [header, data.slice(4 + size)];
}

// Messages that stand in the page itself (`pirvs view RUN --save`), as base64: nobody to talk to.
export class Recorded {
  constructor(handlers, onState, messages) {
    setTimeout(() => {
      onState(true);
      for (const {binary, base64} of messages) {
        const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
        const [message, array] = decode(binary ? bytes.buffer : new TextDecoder().decode(bytes));
        if (handlers[message.type]) handlers[message.type](message, array);
      }
    });
  }
  send() { return false; }
  hostNow() { return null; }
  async command() { return 'error a saved page takes no commands'; }
}

export class Link {
  constructor(handlers, onState) {
    this.handlers = handlers;
    this.onState = onState;
    this.retry_ms = kRetryMin_ms;
    this.pings = [];
    this.received = 0;
    this.answers = new Map();
    this.connect();
    setInterval(() => this.ping(), kPing_ms);
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/`, 'pirvs-view');
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.retry_ms = kRetryMin_ms;
      this.pings = [];
      this.ping();
      this.onState(true);
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = () => {
      this.onState(false);
      for (const done of this.answers.values()) done('error the connection was lost');
      this.answers.clear();
      setTimeout(() => this.connect(), this.retry_ms);
      this.retry_ms = Math.min(kRetryMax_ms, 2 * this.retry_ms);
    };
    this.socket = socket;
  }

  take(data) {
    const [message, array] = decode(data);
    this.received++;
    if (message.type === 'pong') return this.pong(message);
    if (message.type === 'answer') {
      const done = this.answers.get(message.id);
      this.answers.delete(message.id);
      if (done) done(message.text);
    }
    const handler = this.handlers[message.type];
    if (handler) handler(message, array);  // a type that is not known is a newer server's
  }

  send(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  ping() { this.send({type: 'ping', t: performance.now()}); }

  // The quickest of the last: off by half its way at most.
  pong(message) {
    const now = performance.now(), trip = now - message.t;
    this.pings.push({trip, offset: message.host_t * 1000 - message.t - trip / 2});
    if (this.pings.length > kPingsKept) this.pings.shift();
  }

  // The server's clock, ms; null: not known yet.
  hostNow() {
    if (this.pings.length === 0) return null;
    const best = this.pings.reduce((a, b) => (b.trip < a.trip ? b : a));
    return performance.now() + best.offset;
  }

  command(line) {
    return new Promise((done) => {
      const id = Math.random().toString(36).slice(2);
      this.answers.set(id, done);
      if (this.send({type: 'command', id, line})) return;
      this.answers.delete(id);
      done('error not connected');
    });
  }
}
