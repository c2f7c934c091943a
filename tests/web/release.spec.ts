import { execFileSync, spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import {
  chmodSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  rmSync,
  utimesSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Ajv } from "ajv";
import { afterEach, beforeEach, describe, expect, it } from "vitest";

const root = fileURLToPath(new URL("../..", import.meta.url));
const { version } = JSON.parse(readFileSync(join(root, "package.json"), "utf8")) as {
  version: string;
};
const hasDpkg = existsSync("/usr/bin/dpkg-deb");

let work = "";
beforeEach(() => {
  work = mkdtempSync(join(tmpdir(), "isosplat-release-"));
});
afterEach(() => rmSync(work, { recursive: true }));

const run = (command: string, args: string[], env: Record<string, string> = {}) =>
  execFileSync(command, args, { encoding: "utf8", stdio: "pipe", env: { ...process.env, ...env } });
const bytesOf = (file: string) =>
  createHash("sha256")
    .update(readFileSync(join(work, file)))
    .digest("hex");

/**
 * Makes a folder with a Debian package and an archive. Their files are written at this time, in the
 * order of `names`.
 */
function packages(folder: string, names: string[], seconds: number, mode: number) {
  const top = join(work, `${folder}-files`);
  const add = (name: string, text: string) => {
    const file = join(top, name);
    mkdirSync(dirname(file), { recursive: true });
    writeFileSync(file, text);
    chmodSync(file, mode);
    utimesSync(file, seconds, seconds);
  };
  for (const name of names) add(`isosplat/usr/share/${name}`, `text of ${name}`);
  mkdirSync(join(work, folder));
  const paths = names.map((name) => `isosplat/usr/share/${name}`);
  run("tar", ["-czf", join(work, folder, "isosplat.tar.gz"), "-C", top, ...paths]);
  const control = "Package: isosplat\nVersion: 1\nArchitecture: all\nMaintainer: I <i@localhost>\n";
  add("isosplat/DEBIAN/control", `${control}Depends: libc6 (>= 2.34)\nDescription: a test\n`);
  add("isosplat/DEBIAN/md5sums", names.map((name) => `0 ${name}\n`).join(""));
  const deb = join(work, folder, "isosplat_1_all.deb");
  run("dpkg-deb", ["--build", join(top, "isosplat"), deb]);
}

describe.runIf(hasDpkg)("native/packaging/make-reproducible", () => {
  const script = join(root, "native/packaging/make-reproducible");

  it("makes the same bytes from the same files, whatever the time and order of their writing", () => {
    packages("first", ["a", "b"], 1_000_000_000, 0o600);
    packages("second", ["b", "a"], 1_100_000_000, 0o644);
    const files = ["isosplat_1_all.deb", "isosplat.tar.gz"];
    for (const file of files) {
      expect(bytesOf(join("first", file)), file).not.toBe(bytesOf(join("second", file)));
    }
    for (const folder of ["first", "second"]) {
      run(script, [join(work, folder)], { SOURCE_DATE_EPOCH: "1234567890" });
    }
    for (const file of files) {
      expect(bytesOf(join("first", file)), file).toBe(bytesOf(join("second", file)));
    }
    const listed = run("tar", ["--utc", "-tvzf", join(work, "first/isosplat.tar.gz")]);
    expect(listed).toMatch(/^-rw-r--r-- 0\/0 +9 2009-02-13 23:31 isosplat\/usr\/share\/a$/m);
    run("dpkg-deb", ["--raw-extract", join(work, "first/isosplat_1_all.deb"), join(work, "deb")]);
    expect(readFileSync(join(work, "deb/DEBIAN/md5sums"), "utf8")).toMatch(
      /^[0-9a-f]{32} {2}usr\/share\/a\n[0-9a-f]{32} {2}usr\/share\/b\n$/,
    );
  });

  it("needs a time", () => {
    const { SOURCE_DATE_EPOCH: _, ...env } = process.env;
    const result = spawnSync(script, [work], { encoding: "utf8", env });
    expect(result.status).not.toBe(0);
    expect(result.stderr).toContain("expected seconds since 1970");
  });
});

/** The schema of the parts of SPDX 2.3 that .ci/sbom.mjs writes. It allows no other names. */
const identifier = { type: "string", pattern: "^SPDXRef-[A-Za-z0-9.-]+$" };
const text = { type: "string", minLength: 1 };
const object = (required: Record<string, object>, optional: Record<string, object> = {}) => ({
  type: "object",
  required: Object.keys(required),
  properties: { ...required, ...optional },
  additionalProperties: false,
});
const schema = object({
  spdxVersion: { const: "SPDX-2.3" },
  dataLicense: { const: "CC0-1.0" },
  SPDXID: { const: "SPDXRef-DOCUMENT" },
  name: text,
  documentNamespace: { type: "string", pattern: "^[a-z]+:[^#]+$" },
  creationInfo: object({
    created: { type: "string", pattern: "^\\d{4}-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\dZ$" },
    creators: {
      type: "array",
      minItems: 1,
      items: { type: "string", pattern: "^(Person|Organization|Tool): ." },
    },
  }),
  packages: {
    type: "array",
    minItems: 1,
    items: object(
      {
        SPDXID: identifier,
        name: text,
        downloadLocation: { const: "NOASSERTION" },
        filesAnalyzed: { const: false },
      },
      {
        versionInfo: text,
        packageFileName: text,
        licenseConcluded: text,
        licenseDeclared: text,
        copyrightText: text,
        checksums: {
          type: "array",
          items: object({
            algorithm: { const: "SHA256" },
            checksumValue: { type: "string", pattern: "^[0-9a-f]{64}$" },
          }),
        },
        externalRefs: {
          type: "array",
          items: object({
            referenceCategory: { const: "PACKAGE-MANAGER" },
            referenceType: { const: "purl" },
            referenceLocator: { type: "string", pattern: "^pkg:(deb/debian|npm)/[^@]+@[^@]+$" },
          }),
        },
      },
    ),
  },
  relationships: {
    type: "array",
    minItems: 1,
    items: object({
      spdxElementId: identifier,
      relationshipType: { enum: ["DESCRIBES", "CONTAINS", "DEPENDS_ON", "OPTIONAL_DEPENDENCY_OF"] },
      relatedSpdxElement: identifier,
    }),
  },
});

interface Sbom {
  packages: {
    SPDXID: string;
    name: string;
    versionInfo: string;
    checksums?: { checksumValue: string }[];
  }[];
  relationships: { spdxElementId: string; relationshipType: string; relatedSpdxElement: string }[];
}

describe.runIf(hasDpkg && existsSync("/usr/share/doc/emscripten"))("the list of components", () => {
  const write = () => {
    const pagePackages = join(work, "page.json");
    writeFileSync(pagePackages, JSON.stringify(["@awesome.me/webawesome", "lit"]));
    run(process.execPath, [join(root, ".ci/sbom.mjs"), join(work, "all"), pagePackages], {
      SOURCE_DATE_EPOCH: "1234567890",
    });
    return readFileSync(join(work, `all/isosplat-${version}.spdx.json`), "utf8");
  };

  it("has what SPDX 2.3 requires, and all packages with their contents and dependencies", () => {
    packages("all", ["a"], 1_000_000_000, 0o644);
    const python = join(work, "python/DEBIAN");
    mkdirSync(python, { recursive: true });
    writeFileSync(
      join(python, "control"),
      "Package: python3-isosplat\nVersion: 1\nArchitecture: all\nMaintainer: I <i@localhost>\n" +
        "Depends: isosplat (= 1), libc6\nDescription: a test\n",
    );
    run("dpkg-deb", [
      "--build",
      join(work, "python"),
      join(work, "all/python3-isosplat_1_all.deb"),
    ]);
    writeFileSync(join(work, "all/isosplat-1-cp311-cp311-linux_x86_64.whl"), "wheel");
    const written = write();
    expect(written).toBe(write());
    const sbom = JSON.parse(written) as Sbom;
    const validate = new Ajv({ strict: false }).compile(schema);
    validate(sbom);
    expect(validate.errors).toBeNull();

    const ids = sbom.packages.map(({ SPDXID }) => SPDXID);
    expect(new Set(ids).size).toBe(ids.length);
    for (const { spdxElementId, relatedSpdxElement } of sbom.relationships) {
      expect(["SPDXRef-DOCUMENT", ...ids]).toContain(spdxElementId);
      expect(ids).toContain(relatedSpdxElement);
    }
    const byName = new Map(sbom.packages.map((entry) => [entry.name, entry]));
    const deb = byName.get("isosplat_1_all.deb");
    expect(deb?.checksums?.[0]?.checksumValue).toBe(bytesOf("all/isosplat_1_all.deb"));
    const related = (type: string, id = deb?.SPDXID) =>
      sbom.relationships
        .filter((r) => r.spdxElementId === id && r.relationshipType === type)
        .map((r) => sbom.packages.find(({ SPDXID }) => SPDXID === r.relatedSpdxElement)?.name);
    expect(related("DEPENDS_ON")).toEqual(["libc6"]);
    expect(related("CONTAINS")).toEqual(
      expect.arrayContaining(["libxxhash-dev", "emscripten", "lit", "@awesome.me/webawesome"]),
    );
    const module = byName.get("python3-isosplat_1_all.deb")?.SPDXID;
    expect(related("DEPENDS_ON", module)).toEqual(["isosplat_1_all.deb", "libc6"]);
    expect(related("CONTAINS", module)).toContain("pybind11-dev");
    expect(related("CONTAINS", module)).not.toContain("lit");
    const wheel = byName.get("isosplat-1-cp311-cp311-linux_x86_64.whl")?.SPDXID;
    expect(related("CONTAINS", wheel)).toEqual(expect.arrayContaining(["pybind11-dev", "lit"]));
    const lock = JSON.parse(readFileSync(join(root, "package-lock.json"), "utf8"));
    expect(byName.get("lit")?.versionInfo).toBe(lock.packages["node_modules/lit"].version);
    const libc = run("dpkg-query", ["-W", "-f", `$\{Version}`, "libc6"]);
    expect(byName.get("libc6")?.versionInfo).toBe(libc);
  });

  it("cannot be made from an empty folder", () => {
    mkdirSync(join(work, "all"));
    expect(write).toThrow("found none: npm run release");
  });
});

const pagePackages = join(root, "build/page.packages.json");
it.runIf(existsSync(pagePackages))(
  "the copyright of the packages names what the page contains",
  () => {
    const copyright = readFileSync(join(root, "native/packaging/copyright"), "utf8");
    const names = JSON.parse(readFileSync(pagePackages, "utf8")) as string[];
    expect(names.length).toBeGreaterThan(10);
    for (const name of names) {
      expect(copyright).toMatch(new RegExp(`[( ]${name.replaceAll(".", "\\.")}[),\n]`));
    }
  },
);
