/* Streams a model until its error is at most one pixel. Then prints the size of the cut. In C.
 *
 *   embed_c lode://HOST[:PORT]/MODEL */

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <lodestream.h>

/* Returns a view of the model's box from the front and slightly above. The box fills the picture. */
static lodestream_view frame(const lodestream_model* model) {
  lodestream_view view = {.up = {0, 1, 0}, .fov_y_deg = 45, .width_px = 1280, .height_px = 720, .threshold_px = 1};
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = (model->box_max[axis] - model->box_min[axis]) / 2;
    view.target[axis] = view.eye[axis] = model->box_min[axis] + half;
    squared += half * half;
  }
  view.eye[1] += sqrt(squared);
  view.eye[2] += 2.5 * sqrt(squared);
  return view;
}

static int fail(void) {
  fprintf(stderr, "embed_c: %s\n", lodestream_last_error());
  return EXIT_FAILURE;
}

/* Checks the indices of a mesh. A renderer would upload the mesh instead. */
static int is_sound(const lodestream_arrays* mesh) {
  for (uint32_t i = 0; i < 3 * mesh->triangles; ++i)
    if (mesh->indices[i] >= mesh->vertices) return 0;
  return 1;
}

static int walk(const lodestream_cut* cut, const lodestream_view* view) {
  lodestream_cut_info info;
  lodestream_cut_describe(cut, &info);
  size_t* numbers = malloc((info.parts + info.fallbacks) * sizeof *numbers);
  size_t count = 0;
  int good = numbers != NULL && lodestream_cut_shown(cut, view, numbers, &count);
  uint64_t visible = 0;
  for (size_t i = 0; good && i < count; ++i) {
    lodestream_part part;
    lodestream_arrays arrays;
    lodestream_mesh* mesh = lodestream_take_mesh(cut, numbers[i], &arrays);
    good = mesh != NULL && lodestream_cut_part(cut, numbers[i], &part);
    if (!good) break;
    if (!is_sound(&arrays)) printf("node %" PRIu64 " is damaged\n", part.node);
    visible += part.is_visible ? part.triangles : 0;
    lodestream_release_mesh(mesh);
  }
  free(numbers);
  if (!good) return fail();
  printf("%" PRIu64 " triangles in %zu parts, %" PRIu64 " of them in the picture, largest error %.2f pixels\n",
         info.triangles, info.parts, visible, (double)info.max_error_px);
  return EXIT_SUCCESS;
}

static int run(lodestream_stream* stream) {
  lodestream_status status = {0};
  while (!status.is_open)
    if (!lodestream_step(stream, 1000, &status) || status.has_ended) return fail();

  lodestream_model model;
  if (!lodestream_describe(stream, &model)) return fail();
  const lodestream_view view = frame(&model);
  if (!lodestream_set_view(stream, &view)) return fail();

  /* A game would step once per frame without waiting, and take the cut when cut_serial changes. */
  do {
    if (!lodestream_step(stream, 1000, &status) || status.has_ended) return fail();
  } while (!status.is_settled);
  lodestream_cut* cut = lodestream_take_cut(stream);
  if (cut == NULL) return fail();
  const int result = walk(cut, &view);
  lodestream_release_cut(cut);
  printf("%" PRIu64 " bytes received\n", status.received_bytes);
  return result;
}

int main(int count, char** arguments) {
  if (count != 2) {
    fprintf(stderr, "usage: embed_c lode://HOST[:PORT]/MODEL\n");
    return 2;
  }
  lodestream_stream* stream = lodestream_open(arguments[1], NULL);
  if (stream == NULL) return fail();
  const int result = run(stream);
  lodestream_close(stream);
  return result;
}
