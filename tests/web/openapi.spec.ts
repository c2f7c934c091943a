/** Compares the responses of a real server with its OpenAPI document, for each route and status. */
import { execFileSync } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { type IncomingHttpHeaders, request } from "node:http";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import Ajv2020 from "ajv/dist/2020.js";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { program, type RunningServer, serve } from "../browser/support/server.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const store = join(root, "tests/golden/v1.0/u8.isosplat");
const bundle = join(root, "tests/golden/bundle1.0/golden.isobundle");
const token = "0123456789abcdef-all-volumes";
const bearer = { Authorization: `Bearer ${token}` };

interface Media {
  schema: object;
}
interface Documented {
  headers?: Record<string, { schema: object }>;
  content?: Record<string, Media>;
}
interface Operation {
  parameters?: ({ $ref: string } | { name: string; in: string; required: boolean })[];
  responses: Record<string, Documented | { $ref: string }>;
}
interface OpenApi {
  openapi: string;
  paths: Record<string, { get: Operation }>;
  components: { responses: Record<string, Documented> };
}
/** The document, as a server sends it. */
let document: OpenApi;
let paths: { path: string; get: Operation }[] = [];

interface Answer {
  status: number;
  headers: IncomingHttpHeaders;
  body: Buffer;
}

const servers: RunningServer[] = [];
const folder = mkdtempSync(join(tmpdir(), "isosplat-openapi-"));

/** Starts a server with these files and returns its port. */
async function start(name: string, files: Record<string, Buffer | string>, options: string[]) {
  const stores = join(folder, name);
  mkdirSync(stores);
  for (const [file, content] of Object.entries(files)) writeFileSync(join(stores, file), content);
  const server = await serve([stores], 0, options);
  servers.push(server);
  return Number(new URL(server.url).port);
}

async function get(port: number, path: string, headers: Record<string, string> = {}) {
  const asked = request({ host: "127.0.0.1", port, path, headers, agent: false });
  asked.end();
  const [answer] = await once(asked, "response");
  const parts: Buffer[] = [];
  for await (const part of answer) parts.push(part as Buffer);
  const { statusCode, headers: fields } = answer as {
    statusCode: number;
    headers: IncomingHttpHeaders;
  };
  return { status: statusCode, headers: fields, body: Buffer.concat(parts) } satisfies Answer;
}

/** Sends a request that client libraries refuse to send. */
async function getRaw(port: number, head: string): Promise<Answer> {
  const socket = connect(port, "127.0.0.1");
  socket.write(`${head}\r\nHost: localhost\r\nConnection: close\r\n\r\n`);
  const parts: Buffer[] = [];
  for await (const part of socket) parts.push(part as Buffer);
  const answer = Buffer.concat(parts).toString();
  const end = answer.indexOf("\r\n\r\n");
  const [first = "", ...lines] = answer.slice(0, end).split("\r\n");
  const headers = lines.map((line) => {
    const colon = line.indexOf(":");
    return [line.slice(0, colon).toLowerCase(), line.slice(colon + 2)];
  });
  return {
    status: Number(first.split(" ")[1]),
    headers: Object.fromEntries(headers),
    body: Buffer.from(answer.slice(end + 4)),
  };
}

const ajv = new Ajv2020({ strict: false });
ajv.addFormat("binary", true);

/** Checks a value by a schema of the document (a JSON pointer). Returns the errors. */
function valid(pointer: string, value: unknown): string {
  const check = ajv.getSchema(`api#${pointer}`);
  if (!check) throw new Error(`no schema at ${pointer}`);
  return check(value) ? "" : `${pointer}: ${ajv.errorsText(check.errors)}`;
}

const escaped = (part: string) => part.replaceAll("~", "~0").replaceAll("/", "~1");

const checked = new Set<string>();

/** Compares a response with its description in the document, by route and status. */
function check(path: string, answer: Answer) {
  const place = `${path} ${answer.status}`;
  const response = document.paths[path]?.get.responses[answer.status];
  expect(response, `${place} is not documented: ${answer.body.toString()}`).toBeDefined();
  if (!response) return;
  let pointer = `/paths/${escaped(path)}/get/responses/${answer.status}`;
  let documented = response as Documented;
  if ("$ref" in response) {
    pointer = response.$ref.slice(1);
    documented = document.components.responses[pointer.split("/").pop() ?? ""] as Documented;
  }
  for (const name of Object.keys(documented.headers ?? {})) {
    const value = answer.headers[name.toLowerCase()];
    const error = valid(`${pointer}/headers/${escaped(name)}/schema`, value);
    expect(error, `${place} ${name}`).toBe("");
  }
  const type = answer.headers["content-type"]?.split(";")[0];
  if (!documented.content) {
    expect(answer.body.length, place).toBe(0);
  } else {
    expect(Object.keys(documented.content), place).toContain(type);
    if (type === "application/json") {
      const body: unknown = JSON.parse(answer.body.toString());
      const schema = `${pointer}/content/${escaped(type)}/schema`;
      expect(valid(schema, body), place).toBe("");
    }
  }
  checked.add(place);
}

describe("openapi.json", () => {
  let content = "";
  let sceneContent = "";
  let chunk = { level: 0, x: 0, y: 0, z: 0, band: 0 };
  const ports = { open: 0, closed: 0, broken: 0, rated: 0 };

  const queries: Record<string, string> = {
    chunks: "?isovalue=-1e9..1e9&level=0",
    isovalues: "?isovalue=0..200&steps=5",
    samples: "?isovalue=100",
  };

  /** The path of a request for the route, of a volume or a scene. */
  function target(path: string, volume = "open"): string {
    const { level, x, y, z, band } = chunk;
    const query =
      queries[path.split("/").pop() ?? ""] ??
      (path.endsWith("/batch") ? `?chunks=${level}/${x}.${y}.${z}/${band}` : "");
    const values: Record<string, string | number> = {
      name: volume,
      content: path.startsWith("/v1/scenes") ? sceneContent : content,
      page: 0,
      ...chunk,
    };
    return path.replaceAll(/\{(\w+)\}/g, (_all, name: string) => String(values[name])) + query;
  }

  beforeAll(async () => {
    const bytes = readFileSync(store);
    const broken = bytes.subarray(0, 100);
    const tokens = join(folder, "tokens");
    writeFileSync(tokens, `anyone open scene:open\n${token} *\n`);
    writeFileSync(join(folder, "closed-tokens"), `${token} *\n`);
    const picture = join(folder, "picture.webp");
    execFileSync(program, ["render", store, "-i", "60", "--size", "48x30", "-o", picture]);
    const scenePicture = join(folder, "scene.webp");
    execFileSync(program, ["render", bundle, "--size", "48x30", "-o", scenePicture]);
    const files = {
      "open.isosplat": bytes,
      "open.isosplat.webp": readFileSync(picture),
      "broken.isosplat": broken,
      "open.isobundle": readFileSync(bundle),
      "open.isobundle.webp": readFileSync(scenePicture),
      "broken.isobundle": readFileSync(bundle).subarray(0, 100),
    };
    ports.open = await start("open", files, ["--token-file", tokens]);
    ports.closed = await start("closed", files, ["--token-file", join(folder, "closed-tokens")]);
    ports.broken = await start("broken", { "broken.isosplat": broken }, []);
    ports.rated = await start("rated", files, ["--rate-requests", "0.1"]);
    document = JSON.parse((await get(ports.open, "/v1/openapi.json")).body.toString()) as OpenApi;
    paths = Object.entries(document.paths).map(([path, { get }]) => ({ path, get }));
    ajv.addSchema(document, "api");
    const volume = JSON.parse((await get(ports.open, "/v1/volumes/open")).body.toString());
    content = `${volume.contentId}`;
    const scene = JSON.parse((await get(ports.open, "/v1/scenes/open")).body.toString());
    sceneContent = `${scene.contentId}`;
    const frames = await get(ports.open, target("/v1/volumes/{name}/{content}/chunks"));
    const word = (i: number) => frames.body.readUInt32LE(4 * i);
    chunk = { level: word(2), x: word(3), y: word(4), z: word(5), band: word(6) };
  }, 60_000);

  afterAll(async () => {
    for (const server of servers) await server.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("is OpenAPI 3.1, and all of its references resolve", () => {
    expect(document.openapi).toBe("3.1.0");
    const references = JSON.stringify(document).matchAll(/"\$ref":"#([^"]+)"/g);
    for (const [, pointer = ""] of references) {
      const found = pointer
        .split("/")
        .slice(1)
        .reduce<unknown>((value, key) => (value as Record<string, unknown>)?.[key], document);
      expect(found, pointer).toBeDefined();
    }
  });

  test("has the routes of HTTP.md, with their parameters", () => {
    const table = readFileSync(join(root, "server/HTTP.md"), "utf8").split("\n");
    const routes = table
      .map((line) => /^\| GET \| `([^`?[]+)[^`]*` /.exec(line)?.[1])
      .filter((route) => route !== undefined)
      .map((route) => route.replace(/^…/, "/v1/volumes/{name}"))
      .filter((route) => !route.endsWith("…"));
    expect(routes).toEqual(paths.map(({ path }) => path));
    for (const { path, get } of paths) {
      const inPath = (get.parameters ?? []).flatMap((parameter) =>
        "$ref" in parameter ? [parameter.$ref.split("/").pop()] : [],
      );
      const inScenes: Record<string, string> = { name: "sceneName", content: "sceneContent" };
      const expected = [...path.matchAll(/\{(\w+)\}/g)].map(([, name = ""]) => name);
      const isOfScenes = path.startsWith("/v1/scenes");
      expect(inPath).toEqual(expected.map((name) => (isOfScenes ? inScenes[name] : name)));
    }
  });

  test("has the errors of HTTP.md", () => {
    const document = readFileSync(join(root, "server/HTTP.md"), "utf8");
    const codes = [...document.matchAll(/^\| ([45]\d\d) \|/gm)].map((match) => match[1]);
    const described = paths.flatMap(({ get }) =>
      Object.keys(get.responses).filter((code) => code >= "400"),
    );
    // 405 answers methods other than GET. The description of the API states it.
    expect([...new Set(described)].sort()).toEqual(
      [...new Set(codes.filter((code) => code !== "405"))].sort(),
    );
  });

  test("describes the responses of every route", async () => {
    const port = ports.open;
    for (const { path, get: operation } of paths) {
      const url = target(path);
      const answer = await get(port, url);
      expect(answer.status, `${url}: ${answer.body.toString()}`).toBe(200);
      check(path, answer);
      const statuses = operation.responses;
      const has = (status: number) => String(status) in statuses;
      const { etag } = answer.headers;
      if (has(304)) check(path, await get(port, url, { "If-None-Match": etag ?? "" }));
      if (has(412)) check(path, await get(port, url, { "If-Match": '"another"' }));
      if (has(206)) check(path, await get(port, url, { Range: "bytes=10-19" }));
      if (has(416)) check(path, await get(port, url, { Range: "bytes=999999999-" }));
      if (has(404)) check(path, await get(port, target(path, "none"), bearer));
      if (has(500)) check(path, await get(port, target(path, "broken"), bearer));
      if (has(401)) check(path, await get(ports.closed, url, { "X-Forwarded-For": "192.0.2.1" }));
      check(path, await get(port, `${url.split("?")[0]}%zz`));
      const more = await get(port, `${url}${url.includes("?") ? "&" : "?"}another=1`);
      expect(more.status, `${url} with another parameter`).toBe(400);
      check(path, await get(port, url, { Host: "attacker.example" }));
      check(path, await getRaw(port, `GET ${url}${"?"}${"a".repeat(8200)} HTTP/1.1`));
      check(path, await getRaw(port, `GET ${url} HTTP/1.1\r\nX-Long: ${"a".repeat(17_000)}`));
      check(path, await getRaw(port, `GET ${url} HTTP/2.0`));
      if (path === "/readyz") check(path, await get(ports.broken, url));
      await get(ports.rated, "/healthz");
      check(path, await get(ports.rated, url));
    }
    const documented = paths.flatMap(({ path, get }) =>
      Object.keys(get.responses).map((status) => `${path} ${status}`),
    );
    // This test does not cause 413, which needs a larger store, and 503, which needs bodies that
    // exceed the memory.
    const missing = documented.filter((place) => !checked.has(place));
    expect(missing.filter((place) => !/ (413|503)$/.test(place))).toEqual([]);
  }, 120_000);
});
