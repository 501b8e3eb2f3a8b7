// What glows: a soft disc of light, and words that always face the viewer.
import {
  AdditiveBlending,
  CanvasTexture,
  type ColorRepresentation,
  Sprite,
  SpriteMaterial,
  type Texture,
} from "three";
import { make } from "../elements/make.ts";
import { penOf } from "../tiles/tile.ts";
import { named } from "./labels.ts";

export function glowTexture(): Texture {
  const canvas = make("canvas", "", { width: 128, height: 128 });
  const pen = penOf(canvas);
  const light = pen.createRadialGradient(64, 64, 0, 64, 64, 64);
  light.addColorStop(0, "rgba(255,255,255,1)");
  light.addColorStop(0.25, "rgba(255,255,255,.45)");
  light.addColorStop(0.6, "rgba(255,255,255,.1)");
  light.addColorStop(1, "rgba(255,255,255,0)");
  pen.fillStyle = light;
  pen.fillRect(0, 0, 128, 128);
  return new CanvasTexture(canvas);
}

export function glow(texture: Texture, color: ColorRepresentation, size: number): Sprite {
  const look = { map: texture, color, blending: AdditiveBlending, depthWrite: false };
  const sprite = new Sprite(new SpriteMaterial(look));
  sprite.scale.setScalar(size);
  return sprite;
}

// size: share of the view's height.
export function words(text: string, color: string, size: number): Sprite {
  const canvas = make("canvas");
  const pen = penOf(canvas);
  const font = '600 44px "Inter", "Segoe UI", system-ui, sans-serif';
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 16;
  canvas.height = 60;
  pen.font = font;
  pen.fillStyle = color;
  pen.textBaseline = "middle";
  pen.fillText(text, 8, 32);
  const look = { transparent: true, depthWrite: false, sizeAttenuation: false };
  const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), ...look }));
  sprite.scale.set((size * canvas.width) / canvas.height, size, 1);
  return named(sprite);
}
