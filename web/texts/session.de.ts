import type { sessionTexts as English } from "./session.ts";

export const session: typeof English = {
  tooLarge: (most, found) => `Eine Sitzung hat höchstens ${most} Bytes, gefunden ${found}`,
  fileTooLarge: (name, most, found) =>
    `${name}: Erwartet wird eine Sitzungsdatei von höchstens ${most} Bytes, gefunden ${found}`,
  noVolume: (name) =>
    `${name}: In „view“ wird der Name eines Volumens oder die Adresse eines Volumens erwartet`,
  tooLong: (name, most) =>
    `${name}: Erwartet werden Ansicht und Messungen, die in eine Adresse von ${most} Zeichen passen, weil dieser Browser keine Daten der Seite aufbewahrt: Erlauben Sie es ihm, und öffnen Sie die Datei noch einmal`,
  noJson: "Erwartet wird eine Sitzungsdatei (JSON), gefunden etwas anderes",
  noSession: (format) => `Erwartet wird "format": "${format}": Das ist keine Sitzungsdatei`,
  otherVersion: (expected, found) =>
    `Erwartet wird Version ${expected} des Sitzungsformats, gefunden ${found}: Öffnen Sie die Datei mit einer neueren Seite`,
  noView: 'Erwartet wird "view": die Abfrage einer Adresse, wie "?volume=head"',
  noContentId: 'Als "content_id" wird ein Text erwartet',
  noList: (most) => `Erwartet wird "measurements": eine Liste von höchstens ${most}`,
  tooManyPoints: (most, found) =>
    `Erwartet werden höchstens ${most} Punkte in allen Messungen, gefunden ${found}`,
  noKind: (measurement, kinds) =>
    `Messung ${measurement}: Als "kind" wird eines von ${kinds} erwartet`,
  counts: (least, most) => `${least} bis ${most}`,
  noPoints: (measurement, count, kind) =>
    `Messung ${measurement}: Erwartet werden für ${kind} ${count} Punkte in "points"`,
  noText: (measurement, most) =>
    `Messung ${measurement}: Erwartet wird "text" mit höchstens ${most} Zeichen und bei Notizen mindestens einem`,
  noPosition: (measurement) =>
    `Messung ${measurement}: Erwartet wird "position": drei endliche Zahlen`,
};
