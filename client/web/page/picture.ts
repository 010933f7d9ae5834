import { Scene } from "three";
import type { FrameAnswer, Part, ShowMode } from "./contract";
import type { CoreModel } from "./core_model";
import { MeshSet } from "./mesh_set";
import type { Screen } from "./screen";
import { TileTextures } from "./tile_textures";

/** Draws a model as the core describes it. */
export class Picture {
  private readonly scene = new Scene();
  private readonly textures: TileTextures;
  private readonly meshes: MeshSet;
  private parts: Part[] = [];
  private features = -1;
  private look = ""; // uniforms of the last picture

  constructor(
    model: CoreModel,
    private readonly screen: Screen,
  ) {
    this.textures = new TileTextures(model, screen);
    this.meshes = new MeshSet(model, this.scene, screen.programs);
    this.scene.matrixWorldAutoUpdate = false;
    this.scene.add(screen.background.clone());
  }

  /** Number of parts in the picture. */
  get partCount(): number {
    return this.meshes.partCount;
  }

  /** Ids of the meshes in the picture. */
  get ids(): number[] {
    return this.meshes.ids;
  }

  /** True while meshes of the next list are uploaded: draw again in the next frame. */
  get isWaiting(): boolean {
    return this.meshes.isWaiting;
  }

  /** Draws a frame, unless the picture would be the same. @returns true if it was drawn. */
  draw(answer: FrameAnswer, show: ShowMode, has_changed = false): boolean {
    const { programs } = this.screen;
    const has_new_tiles = this.textures.update();
    const { exist, has_clear } = this.textures;
    const features = programs.featuresOf(show, exist, has_clear);
    if (answer.parts || features !== this.features) {
      this.parts = answer.parts ?? this.parts;
      this.features = features;
      this.meshes.setParts(this.parts, features);
    }
    const has_uploads = this.meshes.isWaiting;
    this.meshes.update();
    if (this.look === "" && this.partCount === 0) return false; // shaders of the first picture may still compile
    const look = JSON.stringify(answer.uniforms);
    if (!has_changed && !has_uploads && !has_new_tiles && look === this.look) return false;
    this.look = look;
    for (const [name, value] of Object.entries(answer.uniforms)) programs.set(name, value);
    programs.set("tile_layers", this.textures.layers);
    programs.set("tile_table", this.textures.table);
    programs.setChanged();
    this.screen.draw(this.scene);
    return true;
  }

  dispose(): void {
    this.meshes.dispose();
    this.textures.dispose();
  }
}
