/**
 * The dashboard for Grafana, the rules of docs/deploy.md and the table of server/HTTP.md name the
 * metrics of a server.
 */
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { get } from "node:https";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { makeCertificate } from "../support/certificate.ts";
import { freePort } from "../support/nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const read = (file: string) => readFileSync(join(root, file), "utf8");

interface Panel {
  id: number;
  type: string;
  title: string;
  gridPos: { x: number; y: number; w: number; h: number };
  datasource: { uid: string };
  targets: { refId: string; expr: string }[];
}
interface Dashboard {
  uid: string;
  title: string;
  schemaVersion: number;
  templating: { list: { name: string; query: string | { query: string } }[] };
  panels: Panel[];
}
const dashboard = JSON.parse(read("native/packaging/grafana-dashboard.json")) as Dashboard;
const expressions = dashboard.panels.flatMap((panel) => panel.targets.map(({ expr }) => expr));

/** The names of metrics in a text, and the labels by which the text compares or groups them. */
const namesIn = (text: string) => [...new Set(text.match(/\b(?:isosplat|process)_[a-z_]+\b/g))];
const labelsIn = (text: string) =>
  [...text.matchAll(/(\w+)\s*(?:=~|!~|!=|=)\s*"|\b(?:by|ignoring)\s*\(([^)]*)\)/g)].flatMap(
    ([, compared, grouped]) => (compared ? [compared] : (grouped ?? "").split(/\s*,\s*/)),
  );

describe("the metrics of a server with TLS", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-dashboard-"));
  const names = new Set<string>();
  const labels = new Set<string>(["job", "instance"]); // Prometheus adds these two
  let server: ReturnType<typeof spawn> | undefined;

  beforeAll(async () => {
    const { certificate, key } = makeCertificate(folder, "localhost");
    writeFileSync(join(folder, "tokens"), "anyone *\n");
    const port = await freePort();
    // biome-ignore format: options with their values
    server = spawn(program, [
      "serve", join(root, "tests/golden/v1.0/u8.isosplat"), "--port", String(port),
      "--tls-cert", certificate, "--tls-key", key, "--token-file", join(folder, "tokens"),
    ], { stdio: ["ignore", "pipe", "ignore"] });
    if (server.stdout) await once(server.stdout, "data");
    const ca = readFileSync(certificate);
    const body = async (path: string) => {
      const [answer] = await once(get(`https://localhost:${port}${path}`, { ca }), "response");
      let text = "";
      for await (const part of answer) text += part;
      return text;
    };
    await body("/v1/volumes");
    for (const line of (await body("/metrics")).split("\n")) {
      const name = /^# TYPE (\w+)/.exec(line)?.[1];
      if (name) names.add(name);
      if (!line.startsWith("#")) for (const label of labelsIn(line)) labels.add(label);
    }
  }, 60_000);

  afterAll(async () => {
    server?.kill("SIGTERM");
    if (server) await once(server, "exit");
    rmSync(folder, { recursive: true, force: true });
  });

  const isThere = (name: string) => names.has(name.replace(/_(?:bucket|sum|count)$/, ""));

  test("are those of the dashboard", () => {
    expect(names.size).toBeGreaterThan(20);
    expect(expressions.length).toBeGreaterThan(20);
    for (const expression of expressions) {
      expect(namesIn(expression).length, expression).toBeGreaterThan(0);
      expect(namesIn(expression).filter((name) => !isThere(name))).toEqual([]);
      expect(labelsIn(expression).filter((label) => !labels.has(label))).toEqual([]);
    }
    for (const { name, query } of dashboard.templating.list) {
      if (typeof query !== "string") {
        expect(namesIn(query.query).filter(isThere).length, name).toBe(1);
      }
    }
  });

  test("are those of the rules in docs/deploy.md", () => {
    const section = read("docs/deploy.md").split("### Watching it")[1] ?? "";
    const rules = section.split("```")[1] ?? "";
    expect(namesIn(rules).length).toBeGreaterThan(4);
    expect(namesIn(rules).filter((name) => !isThere(name))).toEqual([]);
    expect(labelsIn(rules).filter((label) => !labels.has(label))).toEqual([]);
  });

  test("are those of server/HTTP.md", () => {
    const section = read("server/HTTP.md").split("## For operators")[1]?.split("\n## ")[0] ?? "";
    const cells = section.split("\n").map((line) => /^\| (`.*?) \|/.exec(line)?.[1] ?? "");
    expect(namesIn(cells.join("\n")).sort()).toEqual([...names].sort());
  });
});

describe("the dashboard", () => {
  test("has panels that do not overlap", () => {
    const taken = new Set<string>();
    for (const { title, gridPos } of dashboard.panels) {
      expect(gridPos.x + gridPos.w, title).toBeLessThanOrEqual(24);
      for (let x = gridPos.x; x < gridPos.x + gridPos.w; ++x) {
        for (let y = gridPos.y; y < gridPos.y + gridPos.h; ++y) {
          expect(taken.has(`${x}.${y}`), title).toBe(false);
          taken.add(`${x}.${y}`);
        }
      }
    }
    expect(new Set(dashboard.panels.map(({ id }) => id)).size).toBe(dashboard.panels.length);
  });

  test("queries the chosen data source, job and server", () => {
    const variables = dashboard.templating.list.map(({ name }) => name);
    expect(variables).toEqual(["datasource", "job", "instance"]);
    // biome-ignore lint/suspicious/noTemplateCurlyInString: Grafana's variable
    const source = "${datasource}";
    for (const panel of dashboard.panels) expect(panel.datasource.uid).toBe(source);
    for (const expression of expressions) {
      for (const name of namesIn(expression)) {
        expect(expression).toContain(`${name}{job=~"$job",instance=~"$instance"`);
      }
    }
  });
});
