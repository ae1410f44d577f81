import type { App } from "./app.ts";
import { sendFilm } from "./record/film.ts";
import { sendPicture } from "./record/pictures.ts";
import type { Received } from "./received.ts";
import type { Message } from "./types.ts";
import { isOutdated } from "./reports.ts";
import { showGhosts } from "./scene/ghosts.ts";
import { scale } from "./scene/legend.ts";

// The action of each kind of message that Python's `panel_message` makes.
const HANDLERS: { [Kind in keyof Received]: (app: App, message: Received[Kind]) => void } = {
  geometry: (app, message) => app.parts.addGeometry(message),
  model: (app, message) => app.parts.addModel(message),
  robot: (app, { model }) => {
    // A page that lost its program before it knew the version receives the whole scene again.
    if (app.robot) app.connection.reload();
    else app.start(app.parts.model(model));
  },
  joints: ({ player, reports, stance }, { q, up, source }) => {
    if (isOutdated(source, reports.source, reports.count, player.playback?.playing)) return;
    stance.display([...q], up, source !== "");
  },
  clip: (app, message) => app.player.load(message),
  still: (app) => app.player.unload(),
  hulls: (app, message) => app.collisions.receive(message),
  shown: (app, message) => app.receiveShown(message),
  frames: (app, message) => app.chooseFrames(message),
  camera: (app, { camera }) => app.camera(camera),
  ghosts: (app, message) => showGhosts(app, message),
  controls: (app, { controls }) => app.controls.show(controls),
  shapes: (app, message) => app.bodyShapes.receive(message),
  targets: (app, { targets }) => app.targets.show(targets),
  colours: (app, { robot, links, label, low, high, stops }) => {
    const shown = robot ? app.others.robots.get(robot)?.shown : app.shown;
    shown?.colours.setScale(new Map(links.map(({ link, rgb }) => [link, rgb])));
    app.legend.set("colours", stops ? scale({ label, low, high }, stops) : []);
  },
  robot_added: (app, message) => app.others.add(message),
  robot_joints: (app, { robot, q, up }) => app.others.display(robot, q, up),
  robot_removed: (app, { robot }) => app.others.remove(robot),
  robots: (app, { robots }) => app.others.keep(robots),
  extra: (app, message) => app.extras.add(message),
  extras: (app, { names }) => app.extras.keep(names),
  lights: (app, { lights }) => app.lights.show(lights),
  reach: (app, message) => app.reach.show(message),
  image: (app, message) => void app.eyes.setImage(message),
  images: (app, { names }) => app.eyes.keepImages(names),
  plot: (app, message) => app.streams.add(message),
  plots: (app, { names }) => app.streams.keep(names),
  capture: (app, message) => void app.eyes.complete().then(() => sendPicture(app, message)),
  film: (app, message) => void app.eyes.complete().then(() => sendFilm(app, message)),
  version: (app, { version }) => app.connection.compare(version),
  complete: (app) => app.complete(),
};

/** Run the action of a message from Python; messages of an unknown kind are ignored. */
export function handleMessage(app: App, message: Message) {
  const handlers: Record<string, (app: App, message: any) => void> = HANDLERS;
  if (Object.hasOwn(handlers, message.kind)) handlers[message.kind](app, message);
}
