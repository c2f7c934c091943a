/** Access logs of servers, which write the line of a response after they have sent it. */
import { randomUUID } from "node:crypto";
import { readFileSync } from "node:fs";

/**
 * The lines of an access log, with those of all responses that were received before the call. To wait
 * for them, this function makes a last request: servers write the lines in order. `request` makes it;
 * its target must contain the name. The lines of such requests are left out.
 */
export async function writtenLog(
  path: string,
  request: (name: string) => Promise<unknown>,
): Promise<string[]> {
  const name = `log-${randomUUID()}`;
  await request(name);
  for (let attempt = 0; attempt < 200; ++attempt) {
    const lines = readFileSync(path, "utf8").trim().split("\n");
    if (lines.some((line) => line.includes(name))) {
      return lines.filter((line) => !/\blog-[0-9a-f]{8}-[-0-9a-f]{27}\b/.test(line));
    }
    await new Promise((next) => setTimeout(next, 50));
  }
  throw new Error(`${path} has no line of ${name}`);
}
