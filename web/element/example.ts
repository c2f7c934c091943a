/** The example page, web/embed.html: two linked views of a volume of this server or site. */
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

const select = document.querySelector<HTMLSelectElement>("#volume");
const state = document.querySelector<HTMLElement>("#state");
const views = document.querySelector<HTMLElement>(".views");
const form = document.querySelector<HTMLFormElement>("#attributes");
const source = document.querySelector<HTMLElement>("#source");

/** The URLs of the volumes, from a server's list or the catalog of a static site. */
async function volumes(): Promise<{ name: string; src: string }[]> {
  const server = await fetch("v1/volumes");
  if (server.ok) {
    const { volumes: list } = (await server.json()) as { volumes: { name: string }[] };
    return list.map(({ name }) => ({ name, src: `v1/volumes/${encodeURIComponent(name)}` }));
  }
  const site = await fetch("catalog.json");
  if (!site.ok) return [];
  const { volumes: list } = (await site.json()) as { volumes: { name: string; url: string }[] };
  return list.map(({ name, url }) => ({ name, src: url }));
}

/** The attributes of both views in addition to `src`; empty ones are left out. */
function attributes(): [first: Map<string, string>, second: Map<string, string>] {
  const entries = [...(form ? new FormData(form) : [])]
    .map(([name, value]) => [name, name === "controls" ? "" : String(value).trim()] as const)
    .filter(([name, value]) => value || name === "controls");
  const second = new Map([
    ["link", "example"],
    ["colour", "c8553d"],
  ]);
  return [new Map(entries), second];
}

function markup(src: string, all: ReadonlyMap<string, string>): string {
  // Escaped for the text of an attribute, since it may be copied into a page.
  const escaped = (text: string) => text.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const list = [["src", src], ...all].map(([name, value]) =>
    value ? `${name}="${escaped(value ?? "")}"` : name,
  );
  return `<isosplat-viewer ${list.join(" ")}></isosplat-viewer>`;
}

/**
 * Sets only changed attributes: setting an attribute again would undo later changes by a visitor.
 */
function assign(element: IsosplatViewerElement, all: ReadonlyMap<string, string>): void {
  const names = "isovalue colour opacity background projection show link controls".split(" ");
  for (const name of names) {
    const value = all.get(name);
    if (value === undefined) element.removeAttribute(name);
    else if (element.getAttribute(name) !== value) element.setAttribute(name, value);
  }
}

function showSource(): void {
  if (!source || !select) return;
  const script = new URL("isosplat-viewer.js", document.baseURI).href;
  const src = new URL(select.value, document.baseURI).href;
  const elements = attributes().map((all) => markup(src, all));
  source.textContent = `<script type="module" src="${script}"></script>\n\n${elements.join("\n")}`;
}

function show(src: string): void {
  const elements = attributes().map((all) => {
    const element = document.createElement("isosplat-viewer");
    element.src = src;
    assign(element, all);
    return element;
  });
  views?.replaceChildren(...elements);
  const [first] = elements;
  first?.addEventListener("progress", (event) => {
    if (state) state.textContent = describe(event.currentTarget as IsosplatViewerElement);
  });
  showSource();
}

function describe({ progress, info }: IsosplatViewerElement): string {
  if (!progress || !info) return "";
  return `${info.voxels.join(" × ")} voxels, ${progress.state}`;
}

const list = await volumes();
select?.append(...list.map(({ name, src }) => new Option(name, src)));
select?.addEventListener("change", () => show(select.value));
form?.addEventListener("submit", (event) => event.preventDefault());
form?.addEventListener("change", () => {
  const [first] = document.querySelectorAll("isosplat-viewer");
  if (!first) return;
  assign(first, attributes()[0]);
  showSource();
});
if (list[0]) show(list[0].src);
else if (state) state.textContent = "There are no volumes here.";
