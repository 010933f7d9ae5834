/* Lodestream's client for other programs: a model on a server, as the mesh that a camera needs now.
 *
 * Open a model, say where the camera is, step, take the cut: parts whose meshes cover what the camera sees,
 * and after each step as fine as has come so far. The library connects, decodes and refines on threads of its
 * own; no function waits for the network, but lodestream_step() as long as it is allowed to. C below; C++ in
 * namespace lodestream at the end.
 *
 * Lengths are the model's unit. Positions of meshes are relative to the model's origin, which keeps them
 * exact in float: true = origin + position. Cameras are in true coordinates. Texts are UTF-8.
 *
 * A stream is for one thread at a time. Cuts and meshes do not change, may be read by any thread, and outlive
 * their stream. Functions that return int return 1, or 0 with lodestream_last_error(); so do those that
 * return a pointer. NULL in place of what a function needs makes it fail, or where it returns nothing does
 * nothing.
 *
 * The header and the library of one version go together: a minor version may change structs. */
#ifndef LODESTREAM_H
#define LODESTREAM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LODESTREAM_VERSION_MAJOR 0
#define LODESTREAM_VERSION_MINOR 5
#define LODESTREAM_VERSION_PATCH 0

typedef struct lodestream_stream lodestream_stream;
typedef struct lodestream_cut lodestream_cut;
typedef struct lodestream_mesh lodestream_mesh;

/* All zeros are the default, as lodestream_default_options() gives it with its values. */
typedef struct lodestream_options {
  const char* token;            /* NULL: none */
  const char* ca_file;          /* authorities for lodes://, in PEM; NULL: the system's */
  const char* cache_folder;     /* keeps what came between runs; NULL: nothing is kept */
  uint64_t memory_budget_bytes; /* of what is known and decoded; 0: 1 GiB */
  uint64_t triangle_budget;     /* of a cut; 0: as many as the view needs */
  uint32_t connect_timeout_ms;  /* up to the server's first word; 0: 20,000 */
  uint32_t decode_threads;      /* at most 256; 0: as many as there are cores but two, at least one */
} lodestream_options;

typedef struct lodestream_model {
  double origin[3];
  double box_min[3], box_max[3]; /* true coordinates */
  uint64_t triangles;            /* of the original */
  uint32_t has_normals, has_colours;
  uint32_t
      has_textures; /* images: without, it may have coordinates of its own, lodestream_arrays.texture_uvs */
} lodestream_model;

/* Finite vectors. A window that is minimized has 0 pixels, which is no view: set none until it is back, and
 * what was set last stays. */
typedef struct lodestream_view {
  double eye[3], target[3], up[3];
  double fov_y_deg;             /* 0.01 to 170 */
  uint32_t width_px, height_px; /* 1 to 32,768 each */
  float threshold_px;           /* largest error allowed in the picture, above 0 */
} lodestream_view;

typedef struct lodestream_status {
  uint32_t is_open;         /* the model is known: lodestream_describe() works */
  uint32_t has_cut;         /* there is something to draw */
  uint32_t is_converged;    /* what the view last set sees is within the threshold */
  uint32_t is_settled;      /* nothing more will come for that view */
  uint32_t is_limited;      /* a budget keeps it from converging */
  uint32_t is_reconnecting; /* the connection broke, and is tried for again; the cut stays */
  uint32_t has_failed;      /* some of it cannot be had: lodestream_last_error() says why */
  uint32_t has_ended;       /* nothing more will come at all: likewise */
  uint64_t received_bytes;
  uint64_t resident_bytes; /* decoded meshes */
  uint64_t cut_serial; /* of the cut that lodestream_take_cut() gives: another one, another cut; 0: none */
  uint32_t is_finest;  /* what that view sees is as fine as the model has it, but not within the threshold */
} lodestream_status;

typedef struct lodestream_cut_info {
  size_t parts;
  size_t fallbacks; /* parts beside the cut, numbered on from its own: see lodestream_cut_shown() */
  size_t tiles, textures;
  uint64_t triangles;
  float max_error_px;    /* of what is seen */
  uint32_t is_converged; /* to the threshold that it was made for */
  uint32_t is_finest;    /* not that, but as fine as the model has it */
  uint64_t serial;       /* of its stream: another one, another cut */
} lodestream_cut_info;

/* Parts of two cuts that are both held have the same mesh where it is named alike: what a renderer has
 * uploaded for the one it can draw for the other. */
typedef struct lodestream_part {
  uint64_t mesh;
  uint64_t node;       /* a leading 1, then 3 bits a level of the octree: x, y, z from the lowest */
  uint32_t lod;        /* 0 is the finest */
  uint32_t is_visible; /* to the cut's own view: draw what lodestream_cut_shown names, visible or not */
  uint64_t triangles;
  float error_px;
} lodestream_part;

/* What lodestream_arrays.texture_of says of a vertex that wears no texture. */
#define LODESTREAM_NO_TEXTURE 0xffffu

/* One value, or group of values, a vertex; NULL for what the model does not have. */
typedef struct lodestream_arrays {
  uint32_t vertices, triangles;
  const float* positions;   /* x y z */
  const float* normals;     /* x y z, unit length */
  const uint8_t* colours;   /* r g b a, sRGB */
  const float* texture_uvs; /* u v; v is 0 at the image's lower edge; it repeats beyond 0 to 1 */
  const uint16_t*
      texture_of; /* number of the vertex's texture, or LODESTREAM_NO_TEXTURE; NULL without textures */
  const uint32_t* indices; /* three a triangle, counter-clockwise */
} lodestream_arrays;

typedef struct lodestream_tile {
  uint32_t texture, level, column, row; /* level 0 is the finest; rows from the image's top */
  uint32_t width_px, height_px;         /* with a gutter of 2 px of the neighbourhood on each side */
  const uint8_t* rgba;                  /* by rows from the top, as long as the cut is held */
} lodestream_tile;

typedef struct lodestream_texture {
  uint32_t width_px, height_px, levels; /* 0: the image is missing */
} lodestream_texture;

/* Of this thread's last call that failed; one line: what, where, what to do. */
const char* lodestream_last_error(void);

/* Fills in the values; texts are NULL. */
void lodestream_default_options(lodestream_options* options);
/* Begins to open lode://HOST[:PORT]/MODEL, or lodes:// with TLS; step until it is open. options: NULL for the
 * default. */
lodestream_stream* lodestream_open(const char* url, const lodestream_options* options);
/* Ends the stream's threads; NULL does nothing, here and where something is released. */
void lodestream_close(lodestream_stream* stream);

/* Waits until there is news since the last step, but no longer than so; 0 does not wait. A view that was set
 * and has settled, the same again, too, is news. */
int lodestream_step(lodestream_stream* stream, uint32_t wait_ms, lodestream_status* status);
int lodestream_describe(lodestream_stream* stream, lodestream_model* model);
/* Once the model is open. */
int lodestream_set_view(lodestream_stream* stream, const lodestream_view* view);

/* The newest cut as of the last step: a reference of the caller's own, to be released. NULL while there is
 * none, which is no error: lodestream_last_error() stays. */
lodestream_cut* lodestream_take_cut(lodestream_stream* stream);
void lodestream_release_cut(lodestream_cut* cut);
/* All zeros of NULL. */
void lodestream_cut_describe(const lodestream_cut* cut, lodestream_cut_info* info);
int lodestream_cut_part(const lodestream_cut* cut, size_t number, lodestream_part* part);
/* Which parts to draw for a camera that may have moved on since the cut was made: the cut's own, but where it
 * sees a place that has not come yet, a fallback for the whole region. numbers has room for parts +
 * fallbacks. */
int lodestream_cut_shown(const lodestream_cut* cut, const lodestream_view* view, size_t* numbers,
                         size_t* count);

/* A part's mesh as flat arrays, made for the caller, to be released. */
lodestream_mesh* lodestream_take_mesh(const lodestream_cut* cut, size_t part, lodestream_arrays* arrays);
void lodestream_release_mesh(lodestream_mesh* mesh);

/* A tile that has come; coarse levels come first and stand in for finer ones. */
int lodestream_cut_tile(const lodestream_cut* cut, size_t number, lodestream_tile* tile);
int lodestream_cut_texture(const lodestream_cut* cut, size_t number, lodestream_texture* texture);

#ifdef __cplusplus
}  // extern "C"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

/// The same, with objects that release what they hold and exceptions in place of return values.
namespace lodestream {

using Options = lodestream_options;
using View = lodestream_view;
using Status = lodestream_status;
using Model = lodestream_model;
using Part = lodestream_part;
using Tile = lodestream_tile;
using Texture = lodestream_texture;

/// What lodestream_last_error() says.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  static void unless(bool good) {
    if (!good) throw Error(lodestream_last_error());
  }
};

inline Options defaultOptions() {
  Options options;
  lodestream_default_options(&options);
  return options;
}

/// A part's triangles. Move only.
class Mesh {
 public:
  Mesh(const lodestream_cut* cut, size_t part) : handle_(lodestream_take_mesh(cut, part, &arrays_)) {
    Error::unless(handle_ != nullptr);
  }
  const lodestream_arrays* operator->() const noexcept { return &arrays_; }

 private:
  struct Release {
    void operator()(lodestream_mesh* mesh) const noexcept { lodestream_release_mesh(mesh); }
  };
  lodestream_arrays arrays_{};
  std::unique_ptr<lodestream_mesh, Release> handle_;
};

/// What to draw. Empty where there is nothing yet. Copies share it.
class Cut {
 public:
  Cut() = default;
  explicit Cut(lodestream_cut* taken) : handle_(taken, &lodestream_release_cut) {
    if (taken != nullptr) lodestream_cut_describe(taken, &info_);
  }
  explicit operator bool() const noexcept { return handle_ != nullptr; }
  const lodestream_cut_info* operator->() const noexcept { return &info_; }
  Part part(size_t number) const {
    Part part;
    Error::unless(lodestream_cut_part(handle_.get(), number, &part) != 0);
    return part;
  }
  /// Numbers of the parts to draw for a camera that may have moved on since.
  std::vector<size_t> shown(const View& view) const {
    std::vector<size_t> numbers(info_.parts + info_.fallbacks);
    size_t count = 0;
    Error::unless(lodestream_cut_shown(handle_.get(), &view, numbers.data(), &count) != 0);
    numbers.resize(count);
    return numbers;
  }
  Mesh mesh(size_t part) const { return Mesh(handle_.get(), part); }
  Tile tile(size_t number) const {
    Tile tile;
    Error::unless(lodestream_cut_tile(handle_.get(), number, &tile) != 0);
    return tile;
  }
  Texture texture(size_t number) const {
    Texture texture;
    Error::unless(lodestream_cut_texture(handle_.get(), number, &texture) != 0);
    return texture;
  }

 private:
  std::shared_ptr<lodestream_cut> handle_;
  lodestream_cut_info info_{};
};

/// A model that streams in. Move only.
class Stream {
 public:
  explicit Stream(const std::string& url, const Options& options = defaultOptions())
      : handle_(lodestream_open(url.c_str(), &options)) {
    Error::unless(handle_ != nullptr);
  }
  /// @throws Error once the stream has ended, too.
  Status step(uint32_t wait_ms) {
    Status status;
    Error::unless(lodestream_step(handle_.get(), wait_ms, &status) != 0 && status.has_ended == 0);
    return status;
  }
  Model describe() const {
    Model model;
    Error::unless(lodestream_describe(handle_.get(), &model) != 0);
    return model;
  }
  void setView(const View& view) { Error::unless(lodestream_set_view(handle_.get(), &view) != 0); }
  Cut takeCut() { return Cut(lodestream_take_cut(handle_.get())); }

 private:
  struct Close {
    void operator()(lodestream_stream* stream) const noexcept { lodestream_close(stream); }
  };
  std::unique_ptr<lodestream_stream, Close> handle_;
};

}  // namespace lodestream
#endif

#endif
