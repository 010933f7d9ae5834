/** Types of the JSON texts that the page and the wasm core exchange. Units are in the names. */

export type Vec3 = [number, number, number];

/** A camera in the model's true coordinates. */
export interface CameraView {
  eye: Vec3;
  target: Vec3;
  up: Vec3;
  fov_y_deg: number;
}

export type CameraKind = "orbit" | "fly" | "walk";
export const kCameraKinds: readonly CameraKind[] = ["orbit", "fly", "walk"];

export type Side = "front" | "back" | "left" | "right" | "top" | "bottom";
export const kSides: readonly Side[] = ["front", "back", "left", "right", "top", "bottom"];

/** Colour modes, as `lodestream view --show` names them. */
export const kShowModes = [
  "surface",
  "unlit",
  "wireframe",
  "normals",
  "texels",
  "nodes",
  "depths",
  "lods",
  "errors",
  "clay",
  "matcap",
] as const;
export type ShowMode = (typeof kShowModes)[number];

export interface OpenOptions {
  model: string;
  token: string;
  memory_bytes: number;
  /** A whole number below 2^32. */
  seed: number;
  has_cache: boolean;
}

export interface Summary {
  name: string;
  build_id: string;
  triangles: number;
  bytes: number;
  depth: number;
  nodes: number;
  has_textures: boolean;
  has_colours: boolean;
  step: number;
  origin: Vec3;
  min: Vec3;
  max: Vec3;
  size_model: number;
}

export interface StartCamera {
  width_px: number;
  height_px: number;
  threshold_px: number;
  up: "x" | "y" | "z" | "-x" | "-y" | "-z" | null;
  camera: CameraView | null;
}

/** Movement by the keys that are held down, from -1 to 1. */
export interface FlyKeys {
  right: number;
  up: number;
  forward: number;
  fast: boolean;
}

/** User input since the last frame, in pixels of the picture, y down. */
export interface FrameInput {
  turned_px?: [number, number];
  shifted_px?: [number, number];
  wheel?: number;
  pointer_px?: [number, number];
  pressed_px?: [number, number];
  double_click_px?: [number, number];
  fly?: FlyKeys;
  reset?: boolean;
  next_camera?: number;
  next_axis?: number;
  side?: Side;
  parallel?: boolean;
}

export interface FrameRequest extends FrameInput {
  width_px: number;
  height_px: number;
  threshold_px: number;
  seconds: number;
  show: ShowMode;
}

/** A mesh to draw: its id, bits of the shader's draw_flags, and its tint. */
export type Part = [id: number, flags: number, tint_rgba: number];

export interface Status {
  triangles: number;
  error_px: number;
  threshold_px: number;
  converged: boolean;
  settled: boolean;
  limited: boolean;
  received_bytes: number;
  cache_bytes: number;
  resident_bytes: number;
  open_requests: number;
  decoding: number;
  link_bytes_per_s: number;
  round_trip_ms: number;
  trouble: string;
  failure: string;
  lost_tiles: number;
  tiles_left_out: number;
  build: string;
}

export interface FrameAnswer {
  kind: CameraKind;
  moving: boolean;
  camera: CameraView;
  uniforms: Record<string, number | number[]>;
  units_per_px: number;
  parallel: boolean;
  /** Changes with the list of parts. Only answers with a new serial contain `parts` and `legend`. */
  serial: number;
  parts?: Part[];
  status: Status;
  legend?: [colour: string, meaning: string][];
}

export interface Pick {
  point: Vec3;
  off_model: number;
}

/** State of the texture array. When the serial changes, the array is new and empty. */
export interface TextureState {
  serial: number;
  layers: number;
  table_words: number;
  /** True if textures have transparent texels. */
  has_clear: boolean;
}

/** An image and the place in the texture array to copy it to. */
export interface TextureUpload {
  layer: number;
  x: number;
  y: number;
  width: number;
  height: number;
  texels: Uint8Array;
}

/** Features of the mesh shader; a sum of these selects a program. */
export const kTextured = 1;
export const kCutOut = 2;
export const kColourMode = 4; // any mode but "surface"
export const kWireframe = 8; // needs kColourMode, and triangles with vertices of their own
