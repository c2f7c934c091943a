import { createSocket, type Socket as UdpSocket } from "node:dgram";
import { type AddressInfo, connect, createServer, type Socket } from "node:net";

/**
 * Passes items on in their order, each this many milliseconds after its arrival. `msEach`: the time
 * for which an item occupies the link; the next one waits.
 */
class Delay<Item> {
  readonly #queue: { at: number; item: Item }[] = [];
  readonly #ms: number;
  readonly #use: (item: Item) => void;
  readonly #msEach: (item: Item) => number;
  #from = 0;

  constructor(ms: number, use: (item: Item) => void, msEach: (item: Item) => number = () => 0) {
    this.#ms = ms;
    this.#use = use;
    this.#msEach = msEach;
  }

  /** Items that arrive before this time are treated as if they arrived at this time. */
  holdUntil(moment: number): void {
    this.#from = moment;
  }

  push(item: Item): void {
    this.#from = Math.max(performance.now(), this.#from) + this.#msEach(item);
    this.#queue.push({ at: this.#from + this.#ms, item });
    if (this.#queue.length === 1) this.#wait();
  }

  #wait(): void {
    const [first] = this.#queue;
    if (first) setTimeout(() => this.#drain(), Math.ceil(first.at - performance.now()));
  }

  #drain(): void {
    while (this.#queue[0] && this.#queue[0].at <= performance.now()) {
      const first = this.#queue.shift();
      if (first) this.#use(first.item);
    }
    this.#wait();
  }
}

/**
 * A relay of TCP and UDP to the same port number of this machine, which delays each direction by
 * half of `roundTripMs`. The three-way handshake of TCP takes another round trip, as on a real link.
 * `megabitsPerSecond` limits each direction of each TCP connection. Nothing is lost.
 */
export async function openDelayedLink(
  to: number,
  roundTripMs: number,
  megabitsPerSecond = Number.POSITIVE_INFINITY,
) {
  const oneWay = roundTripMs / 2;
  const msOf = (data: Buffer | null) => (8 * (data?.length ?? 0)) / (1000 * megabitsPerSecond);
  const sockets = new Set<Socket>();
  const tcp = createServer({ noDelay: true, allowHalfOpen: true }, (client) => {
    const server = connect({ port: to, host: "127.0.0.1", noDelay: true, allowHalfOpen: true });
    const opened = performance.now() + roundTripMs;
    for (const [from, target] of [
      [client, server],
      [server, client],
    ] as const) {
      const delay = new Delay<Buffer | null>(
        oneWay,
        (data) => (data ? target.write(data) : target.end()),
        msOf,
      );
      delay.holdUntil(opened);
      sockets.add(from);
      from.on("data", (data) => delay.push(data));
      from.on("end", () => delay.push(null));
      from.on("error", () => target.destroy());
      from.on("close", () => sockets.delete(from));
    }
  });
  await new Promise<void>((resolve) => tcp.listen(0, "127.0.0.1", resolve));
  const { port } = tcp.address() as AddressInfo;

  const udp = createSocket("udp4");
  const clients = new Map<number, { socket: UdpSocket; up: Delay<Buffer> }>();
  udp.on("message", (data, { port: from }) => {
    let client = clients.get(from);
    if (!client) {
      const socket = createSocket("udp4");
      const down = new Delay<Buffer>(oneWay, (answer) => udp.send(answer, from, "127.0.0.1"));
      socket.on("message", (answer) => down.push(answer));
      client = { socket, up: new Delay(oneWay, (sent) => socket.send(sent, to, "127.0.0.1")) };
      clients.set(from, client);
    }
    client.up.push(data);
  });
  await new Promise<void>((resolve) => udp.bind(port, "127.0.0.1", resolve));

  return {
    port,
    close() {
      tcp.close();
      for (const socket of sockets) socket.destroy();
      // Delayed packets may still be sent, but they do not keep the process running.
      udp.removeAllListeners("message").unref();
      for (const { socket } of clients.values()) socket.unref();
    },
  };
}
