// flooder.ts KIND PORT PATH: floods a server on this machine until its standard input ends.
//
// This is a separate process, which the benchmark runs with low priority. Otherwise, on two cores, it
// would take processor time from the server and from the client that is measured.
import { connect, type Socket } from "node:net";

const [kind = "", portText = "", path = "/"] = process.argv.slice(2);
const port = Number(portText);
const request = (more = "") => `GET ${path} HTTP/1.1\r\nHost: localhost\r\n${more}\r\n`;
const addresses = (count: number) => Array.from({ length: count }, (_, i) => `127.0.0.${i + 2}`);

/** Connects from an address. `bytes`: the limit of a read, after which the socket pauses. */
function join(localAddress: string, bytes?: number): Socket {
  const slowly = bytes
    ? { onread: { buffer: Buffer.alloc(bytes), callback: () => false } }
    : undefined;
  const socket = connect({ port, host: "127.0.0.1", localAddress, ...slowly });
  return socket.on("error", () => {});
}

/** Holds `each` connections from each address. A connection that is closed is opened again. */
function hold(from: string[], each: number, begin: (address: string) => Socket): void {
  const again = (address: string): void => {
    begin(address).on("close", () => setTimeout(() => again(address), 100));
  };
  for (const address of from) for (let i = 0; i < each; ++i) again(address);
}

/** Calls `work` every second until the socket is closed. */
function everySecond(socket: Socket, work: () => void): Socket {
  const timer = setInterval(work, 1000);
  return socket.on("close", () => clearInterval(timer));
}

const kinds: Record<string, () => void> = {
  /** 1,024 connections of four addresses that read 100 bytes per second of a large body. */
  readers: () =>
    hold(addresses(4), 256, (address) => {
      const socket = join(address, 100);
      socket.write(request());
      return everySecond(socket, () => socket.resume());
    }),

  /** 1,024 connections of four addresses that send one byte of a header per second. */
  headers: () =>
    hold(addresses(4), 256, (address) => {
      const socket = join(address);
      socket.write(`GET ${path} HTTP/1.1\r\nHost: localhost\r\nX-Slow: `);
      return everySecond(socket, () => socket.write("x"));
    }),

  /** 1,500 connections per second of eight addresses that begin a TLS handshake, and no more. */
  handshakes: () => {
    const from = addresses(8);
    const begin = performance.now();
    let count = 0;
    setInterval(() => {
      const due = ((performance.now() - begin) / 1000) * 1500;
      for (; count < due; ++count) {
        const socket = join(from[count % from.length] ?? "");
        socket.write(Buffer.from("1603010200010001fc0303", "hex"));
      }
    }, 10);
  },

  /** 40 loops of one address. */
  loops: () =>
    hold(addresses(1), 40, (address) => {
      const socket = join(address);
      socket.write(request("Connection: close\r\n"));
      return socket.resume();
    }),

  /** Every second, 360 pipelined requests on each of four connections of one address. */
  pipelines: () =>
    hold(addresses(1), 4, (address) => {
      const socket = join(address);
      const batch = request().repeat(360);
      socket.write(batch);
      return everySecond(socket.resume(), () => socket.write(batch));
    }),

  /**
   * 64 connections of one address, each of which sends the next request as soon as it has a
   * response.
   */
  greedy: () =>
    hold(addresses(1), 64, (address) => {
      const socket = join(address);
      let missing = 0;
      const ask = () => socket.write(request());
      socket.on("connect", ask).on("data", (data) => {
        if (missing === 0) {
          const end = data.indexOf("\r\n\r\n") + 4;
          const length = data
            .subarray(0, end)
            .toString("latin1")
            .match(/Content-Length: (\d+)/i);
          missing = Number(length?.[1]) + end;
        }
        missing -= data.length;
        if (missing <= 0) {
          missing = 0;
          ask();
        }
      });
      return socket;
    }),
};

const flood = kinds[kind];
if (!flood) throw new Error(`expected one of ${Object.keys(kinds).join(", ")}, found "${kind}"`);
flood();
process.stdin.resume().on("end", () => process.exit());
setTimeout(() => process.exit(), 120_000); // in any case
