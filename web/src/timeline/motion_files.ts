import { button, iconButton, menu } from "../panel/element.ts";
import { download, fileName } from "../record/pictures.ts";
import { Refused } from "../values/literals.ts";
import { WRITERS } from "./formats.ts";
import { KeyFrames } from "./key_frames.ts";
import { Motion } from "./motion.ts";
import type { Player } from "./player.ts";

// A pasted motion with at most this many configurations becomes key frames, a longer one a clip.
const FEW = 60;

/** Saves the motion that is played as a file, and plays pasted ones. */
export class MotionFiles {
  button = iconButton("file", "Save the motion", () => {}, "", "Save");
  menu = menu(
    this.button,
    "Save the motion",
    ...Object.keys(WRITERS).map((format) =>
      button(`Save as ${format.toUpperCase()}`, () => {
        this.menu.hidePopover();
        this.save(format);
      }),
    ),
  );

  constructor(readonly player: Player) {}

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

  take(name: string, read: Motion) {
    const { player } = this;
    // The page's time begins at 0.
    const times = Array.from(read.times, (time) => time - Math.min(read.start, 0));
    const motion = new Motion(times, read.values);
    player.pause();
    const edited = motion.count <= FEW;
    if (edited) player.editor.take(KeyFrames.from(motion));
    else player.setClip(player.playing(motion));
    player.seek(0);
    const what = edited ? "key frames" : "configurations";
    player.say(`${name}: ${motion.count} ${what}, ${motion.end.toFixed(2)} s`);
  }
}
