import type { deviceErrorTexts as English } from "./device_errors.ts";

export const deviceError: typeof English = {
  corsRemedy:
    "oder die Datei ist nicht da. Ihr Betreiber muss „Access-Control-Allow-Origin: *“ senden (CORS); oder laden Sie die Datei herunter, und legen Sie sie hier ab",
  notFoundRemedy: "prüfen Sie die Adresse",
  accessRemedy:
    "öffnen Sie den ganzen Link, den Sie bekommen haben, oder laden Sie die Datei herunter, und legen Sie sie hier ab",
  unreachableRemedy: "prüfen Sie die Adresse und Ihre Verbindung, und öffnen Sie sie noch einmal",
  serverRemedy: "öffnen Sie sie später noch einmal",
  webPage: (address, type) =>
    `${address}: Erwartet wird die Datei eines Volumens, gefunden eine Webseite (${type}): Geben Sie die Adresse der Datei selbst an.`,
  replaced: (address) =>
    `${address}: Die Datei wurde ersetzt, während sie geladen wurde: Öffnen Sie sie noch einmal.`,
  tooLarge: (name, most, found) =>
    `${name}: Erwartet werden höchstens ${most}, gefunden ${found}: Laden Sie die Datei herunter, und wandeln Sie sie mit dem Programm um: isosplat build ${name}`,
  tooManyFiles: (most) =>
    `Erwartet werden höchstens ${most} Dateien, gefunden mehr: Legen Sie nur den Ordner eines Volumens hier ab`,

  keptSize: (stated, found) => `erwartet wurden ${stated} Byte, gefunden ${found}`,
  notAllowed: "Dieser Browser lässt Seiten keine Dateien auf diesem Gerät aufbewahren.",
  notKept: (reason) =>
    `Der Browser hat die Isosplat-Datei nicht auf diesem Gerät aufbewahrt: ${reason}.`,
  notRemoved: (name, reason) =>
    `Der Browser hat ${name} nicht entfernt: ${reason}. Schließen Sie andere Tabs, in denen es offen ist, und versuchen Sie es noch einmal.`,
  noRoom: (needed, found) =>
    `Erwartet werden ${needed} Platz für diese Website auf diesem Gerät, gefunden ${found}: Entfernen Sie andere Volumen von diesem Gerät, oder speichern Sie dieses in eine Datei.`,
  less: "weniger",

  causes: {
    truncated: "Die Datei ist unvollständig, oder ihr Kopf ist falsch.",
    malformed_volume: "Die Datei kann so, wie sie ist, nicht gelesen werden.",
    unsupported_format: "Isosplat kann diese Datei nicht lesen.",
    unsupported_type: "Isosplat kann Voxel dieser Art nicht lesen.",
    no_cells: "Ein Volumen braucht mindestens zwei Voxel entlang jeder Achse.",
    volume_too_large: "Das Volumen hat zu viele Voxel.",
    out_of_memory: "Der Arbeitsspeicher des Browsers ist zu klein.",
    io_error: "Der Browser konnte die Datei nicht lesen.",
    worker_lost: "Der Browser hat das Lesen beendet.",
  },

  noPageFiles: (status) =>
    `files.json: Erwartet wird die Liste der Dateien dieser Seite, gefunden Status ${status}: Laden Sie die Seite neu`,
  noPageFile: (name, status) =>
    `${name}: Erwartet wird eine Datei dieser Seite, gefunden Status ${status}: Die Seite wurde auf ihrem Server erneuert; laden Sie sie neu`,
  pageFileUnreachable: (name) =>
    `${name}: Erwartet wird eine Datei dieser Seite, gefunden keine Netzverbindung: Speichern Sie, sobald der Server erreichbar ist`,
  tooLargeForPage: (most, found) =>
    `Erwartet wird für eine einzelne Seite eine Isosplat-Datei von höchstens ${most}, gefunden ${found}: Speichern Sie stattdessen eine Website`,

  zipFiles: (most) =>
    `Erwartet werden höchstens ${most} Dateien, gefunden mehr: Entpacken Sie es, und legen Sie den Ordner eines Volumens hier ab`,
  zipTooLarge: (most, found) =>
    `Erwartet werden entpackt höchstens ${most}, gefunden mindestens ${found}: Entpacken Sie es, und legen Sie den Ordner hier ab`,
  zipDirectory:
    "Das Verzeichnis ist zu lang: Entpacken Sie es, und legen Sie den Ordner eines Volumens hier ab",
  zipLonger: (name) =>
    `${name} ist länger als angegeben: Das Archiv ist beschädigt; kopieren oder laden Sie es noch einmal`,
  zipShorter: (name) =>
    `${name} ist kürzer als angegeben: Das Archiv ist beschädigt; kopieren oder laden Sie es noch einmal`,
  zipDamaged: "Das Archiv ist beschädigt; kopieren oder laden Sie es noch einmal",
  zipIncomplete:
    "Das ist kein ZIP oder ein unvollständiges: Kopieren oder laden Sie es noch einmal",
  zipEncrypted: "Es ist verschlüsselt: Entpacken Sie es, und legen Sie den Ordner hier ab",
  zipSplit: "Es ist einer von mehreren Teilen: Entpacken Sie es, und legen Sie den Ordner hier ab",
  zipUnsafe:
    "Eine Datei darin hat einen Pfad außerhalb ihres Ordners: Entpacken Sie es, und legen Sie den Ordner hier ab, wenn Sie ihm vertrauen",
  zipCompression:
    "Es ist auf eine Weise komprimiert, die Browser nicht lesen: Entpacken Sie es, und legen Sie den Ordner hier ab",
};
