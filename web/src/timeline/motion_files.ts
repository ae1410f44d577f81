import { button, element, iconButton, menu } from "../panel/element.ts";
import { download, fileName } from "../record/pictures.ts";
import { Refused } from "../values/literals.ts";
import { MOST_BYTES, WRITERS, readMotion } from "./formats.ts";
import { KeyFrames, MOST_KEYS } from "./key_frames.ts";
import { Motion } from "./motion.ts";
import type { Player } from "./player.ts";

// A file with at most this many configurations is opened as key frames, a longer one as a clip.
const FEW = 60;

/** Saves and opens motions as files: by a menu, or by dropping a file on the page. */
export class MotionFiles {
  /** Number of files opened. */
  opened = 0;
  button = iconButton("file", "Motion files", () => {}, "", "Files");
  field = element("input", { type: "file", accept: ".csv,.tsv,.txt,.json", hidden: true, tabIndex: -1 });
  writers: HTMLButtonElement[] = Object.keys(WRITERS).map((format) =>
    button(`Save as ${format.toUpperCase()}`, () => {
      this.menu.hidePopover();
      this.save(format);
    }),
  );
  menu: HTMLDivElement;

  constructor(readonly player: Player) {
    this.field.ariaLabel = "Motion file";
    this.field.onchange = () => {
      const [file] = this.field.files ?? [];
      if (file) this.open(file);
      this.field.value = "";
    };
    const opener = button("Open a CSV or JSON file …", () => {
      this.menu.hidePopover();
      this.field.click();
    });
    this.menu = menu(this.button, "Motion files", ...this.writers, opener);
    player.addEventListener("motion", () => this.refresh());
    window.addEventListener("dragover", (event) => this.over(event));
    window.addEventListener("drop", (event) => this.drop(event));
    this.refresh();
  }

  refresh() {
    for (const writer of this.writers) writer.disabled = this.player.motion === null;
  }

  save(format: string) {
    const { page, motion } = this.player;
    if (!motion) return;
    const { type, write } = WRITERS[format];
    const { about } = page.robot;
    try {
      download(new Blob([write(about, motion)], { type }), fileName(about.name, format));
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.player.say(error.message, true);
    }
  }

  over(event: DragEvent) {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
  }

  drop(event: DragEvent) {
    const [file] = event.dataTransfer?.files ?? [];
    if (!file) return;
    event.preventDefault();
    this.open(file);
  }

  async open(file: File) {
    const { player } = this;
    const number = ++this.opened;
    const name = file.name.length > 60 ? `${file.name.slice(0, 59)}…` : file.name;
    if (file.size > MOST_BYTES) {
      player.say(`${name}: ${(file.size / 1e6).toFixed(0)} MB, more than ${MOST_BYTES / 1e6} MB`, true);
      return;
    }
    try {
      const { robot, stance } = player.page;
      const text = await file.text();
      // Only the file opened last is shown: a short one may be read before a long one that was opened earlier.
      if (number === this.opened) this.take(name, readMotion(robot.about, text.replace(/^\ufeff/, ""), stance.q));
    } catch (error) {
      player.say(`${name}: ${error instanceof Refused ? error.message : "cannot be read"}`, true);
    }
  }

  take(name: string, read: Motion) {
    const { player } = this;
    // The page's time begins at 0.
    const motion =
      read.start < 0
        ? new Motion(
            Array.from(read.times, (time) => time - read.start),
            read.values,
            read.interpolation,
          )
        : read;
    player.pause();
    const edited = motion.count <= (motion.interpolation === "smooth" ? MOST_KEYS : FEW);
    if (edited) player.editor.take(KeyFrames.from(motion));
    else player.setClip(player.playing(motion));
    player.seek(0);
    const what = edited ? "key frames" : "configurations";
    player.say(`${name}: ${motion.count} ${what}, ${motion.end.toFixed(2)} s`);
  }
}
