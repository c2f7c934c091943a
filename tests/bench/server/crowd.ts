// Many simultaneous connections, most of which are idle or harmful.
import { connect, type Socket } from "node:net";

/** The behaviour of a client of the crowd on its connection. */
type Habit = (socket: Socket) => void;

/** Connections that are opened again when the server closes them. */
export class Crowd {
  readonly #port: number;
  readonly #habit: Habit;
  readonly #sockets = new Set<Socket>();
  #isOver = false;
  /** Connections that the server has closed so far. */
  dropped = 0;

  constructor(url: string, habit: Habit) {
    this.#port = Number(new URL(url).port);
    this.#habit = habit;
  }

  /** Connections that are open now. */
  get size(): number {
    return this.#sockets.size;
  }

  /** Opens connections; resolves when all are open. */
  async open(count: number): Promise<void> {
    for (let left = count; left > 0; left -= 100) {
      await Promise.all(Array.from({ length: Math.min(left, 100) }, () => this.#join()));
    }
  }

  /** Sends a text on every connection. Resolves to the number of responses with status 200. */
  async askAll(text: string): Promise<number> {
    const answers = [...this.#sockets].map(
      (socket) =>
        new Promise<boolean>((resolve) => {
          socket.once("data", (data) => resolve(data.toString("latin1").includes(" 200 OK")));
          socket.once("close", () => resolve(false));
          socket.write(text);
        }),
    );
    return (await Promise.all(answers)).filter(Boolean).length;
  }

  close(): void {
    this.#isOver = true;
    for (const socket of this.#sockets) socket.destroy();
  }

  #join(): Promise<void> {
    return new Promise((resolve) => {
      const socket = connect(this.#port, "127.0.0.1", () => {
        this.#sockets.add(socket);
        this.#habit(socket);
        resolve();
      });
      socket.on("error", () => {});
      socket.on("close", () => {
        this.#sockets.delete(socket);
        resolve();
        if (this.#isOver) return;
        ++this.dropped;
        setTimeout(() => this.#isOver || void this.#join(), 100);
      });
    });
  }
}

/** Sends nothing. */
export const idle: Habit = () => {};

/** Requests a large body and reads none of it. */
export const slowReader =
  (path: string): Habit =>
  (socket) => {
    socket.pause();
    socket.write(`GET ${path} HTTP/1.1\r\nHost: localhost\r\n\r\n`);
  };

/** Sends a header, one byte each second. */
export const slowWriter =
  (path: string): Habit =>
  (socket) => {
    socket.write(`GET ${path} HTTP/1.1\r\nHost: localhost\r\nX-Slow: `);
    const timer = setInterval(() => socket.write("x"), 1000);
    socket.on("close", () => clearInterval(timer));
  };
