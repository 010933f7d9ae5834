/* Lodestream client library: streams a model from a server and provides the meshes that a camera needs.
 *
 * Open a stream, set the view, step, and take the cut: a set of parts whose meshes cover everything that
 * the camera sees. Each step may refine the cut. The library connects, decodes and refines on its own
 * threads. No function blocks on the network, except lodestream_step() up to the given timeout. This
 * header declares the C API first, then a C++ wrapper in namespace lodestream.
 *
 * Lengths are in the model's unit. Mesh positions are relative to the model's origin, which keeps them
 * exact in float: true position = origin + position. Views use true coordinates. Strings are UTF-8.
 *
 * Threads: use a stream from one thread at a time. Cuts and meshes are immutable, can be read from any
 * thread, and may outlive their stream.
 *
 * Errors: functions that return int return 1 on success and 0 on failure; functions that return a pointer
 * return NULL on failure. lodestream_last_error() describes the failure. Passing NULL for a required
 * argument is an error; functions without a return value ignore it.
 *
 * Versions: use the header and the library of the same version. Before 1.0, minor versions may change
 * structs. */
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

/* Options of a stream. Zero or NULL selects the default of an option; lodestream_default_options() fills in
 * the default values. */
typedef struct lodestream_options {
  const char* token;            /* access token; NULL: none */
  const char* ca_file;          /* PEM file of authorities for lodes://; NULL: the system's authorities */
  const char* cache_folder;     /* folder that caches received data between runs; NULL: no cache */
  uint64_t memory_budget_bytes; /* limit for hierarchy, received data, meshes and textures; 0: 1 GiB */
  uint64_t triangle_budget;     /* largest number of triangles of a cut; 0: no limit */
  uint32_t connect_timeout_ms;  /* longest time until the server's first byte; 0: 20,000 */
  uint32_t decode_threads;      /* at most 256; 0: the number of cores minus two, at least one */
} lodestream_options;

typedef struct lodestream_model {
  double origin[3];
  double box_min[3], box_max[3]; /* true coordinates */
  uint64_t triangles;            /* number of triangles of the original model */
  uint32_t has_normals, has_colours;
  uint32_t has_textures; /* 1 if there are images; texture_uvs may exist without images */
} lodestream_model;

/* A camera and its picture. Vectors must be finite. Set no view while a window is minimized and has no
 * pixels; the last view stays in effect. */
typedef struct lodestream_view {
  double eye[3], target[3], up[3];
  double fov_y_deg;             /* 0.01 to 170 */
  uint32_t width_px, height_px; /* 1 to 32,768 each */
  float threshold_px;           /* largest projected error allowed; above 0 */
} lodestream_view;

typedef struct lodestream_status {
  uint32_t is_open;         /* the model is open: lodestream_describe() works */
  uint32_t has_cut;         /* lodestream_take_cut() returns a cut */
  uint32_t is_converged;    /* the cut is within the threshold of the view that was set last */
  uint32_t is_settled;      /* the cut is final for the view that was set last */
  uint32_t is_limited;      /* a budget prevents the cut from converging */
  uint32_t is_reconnecting; /* the connection broke and the library reconnects; the last cut stays */
  uint32_t has_failed;      /* a part of the model cannot be loaded: see lodestream_last_error() */
  uint32_t has_ended;       /* the stream has stopped for good: see lodestream_last_error() */
  uint64_t received_bytes;
  uint64_t resident_bytes; /* memory of decoded meshes */
  uint64_t cut_serial;     /* serial number of the current cut; changes with every new cut; 0: none */
  uint32_t is_finest;      /* the cut is the finest that the model has, but exceeds the threshold */
} lodestream_status;

typedef struct lodestream_cut_info {
  size_t parts;
  size_t fallbacks; /* coarser parts, numbered after the parts: see lodestream_cut_shown() */
  size_t tiles, textures;
  uint64_t triangles;
  float max_error_px;    /* largest projected error of the visible parts */
  uint32_t is_converged; /* the cut is within the threshold of its view */
  uint32_t is_finest;    /* the cut is the finest that the model has, but exceeds the threshold */
  uint64_t serial;       /* lodestream_status.cut_serial of this cut */
} lodestream_cut_info;

/* A part of a cut. Parts with the same mesh id have the same mesh, even in different cuts if the caller holds
 * both, so a renderer need not upload the mesh again for the next cut. */
typedef struct lodestream_part {
  uint64_t mesh;       /* mesh id */
  uint64_t node;       /* octree node: a 1, then 3 bits per level: x (lowest bit), y, z */
  uint32_t lod;        /* 0 is the finest */
  uint32_t is_visible; /* visible in the cut's own view; lodestream_cut_shown() selects what to draw */
  uint64_t triangles;
  float error_px; /* projected error in the cut's view */
} lodestream_part;

/* Value of lodestream_arrays.texture_of for a vertex without a texture. */
#define LODESTREAM_NO_TEXTURE 0xffffu

/* Vertex and index arrays of a mesh. Attributes that the model does not have are NULL. */
typedef struct lodestream_arrays {
  uint32_t vertices, triangles;
  const float* positions;     /* x y z */
  const float* normals;       /* x y z, unit length */
  const uint8_t* colours;     /* r g b a, sRGB */
  const float* texture_uvs;   /* u v; v = 0 is the lower edge of the image; the image repeats outside 0..1 */
  const uint16_t* texture_of; /* texture number per vertex, or LODESTREAM_NO_TEXTURE; NULL without textures */
  const uint32_t* indices;    /* three vertices per triangle, counter-clockwise */
} lodestream_arrays;

typedef struct lodestream_tile {
  uint32_t texture, level, column, row; /* level 0 is the finest; row 0 is at the top */
  uint32_t width_px, height_px;         /* including a gutter of 2 px on each side */
  const uint8_t* rgba;                  /* rows from the top; valid until the cut is released */
} lodestream_tile;

typedef struct lodestream_texture {
  uint32_t width_px, height_px, levels; /* all 0 if the image is missing */
} lodestream_texture;

/* Returns the error of the last failed call on this thread, in one line: what failed, where, what to do. */
const char* lodestream_last_error(void);

/* Fills in the default values; strings are NULL. */
void lodestream_default_options(lodestream_options* options);
/* Starts to open lode://HOST[:PORT]/MODEL, or lodes:// with TLS. Call lodestream_step() until the status says
 * is_open. options: NULL selects the defaults. */
lodestream_stream* lodestream_open(const char* url, const lodestream_options* options);
/* Closes the stream and joins its threads. Ignores NULL, as all release functions do. */
void lodestream_close(lodestream_stream* stream);

/* Waits for a change since the last step, at most wait_ms, and returns the status. If wait_ms is 0, returns
 * at once. Setting the same view again after it has settled counts as a change. */
int lodestream_step(lodestream_stream* stream, uint32_t wait_ms, lodestream_status* status);
/* Describes the model. Fails until the model is open. */
int lodestream_describe(lodestream_stream* stream, lodestream_model* model);
/* Sets the view to refine for. Fails until the model is open. */
int lodestream_set_view(lodestream_stream* stream, const lodestream_view* view);

/* Returns a new reference to the cut of the last step; release it with lodestream_release_cut(). Returns
 * NULL if there is no cut yet, which is not an error: lodestream_last_error() does not change. */
lodestream_cut* lodestream_take_cut(lodestream_stream* stream);
void lodestream_release_cut(lodestream_cut* cut);
/* Describes a cut; writes zeros if the cut is NULL. */
void lodestream_cut_describe(const lodestream_cut* cut, lodestream_cut_info* info);
/* Describes a part or a fallback. number: less than parts + fallbacks. */
int lodestream_cut_part(const lodestream_cut* cut, size_t number, lodestream_part* part);
/* Selects what to draw for a camera that may have moved since the cut was refined: the cut's parts, except
 * that a fallback replaces all parts in its region if the camera sees a missing part there. Writes their
 * numbers into the array, which needs room for parts + fallbacks entries, and the number of entries into
 * *count. */
int lodestream_cut_shown(const lodestream_cut* cut, const lodestream_view* view, size_t* numbers,
                         size_t* count);

/* Returns a copy of a part's mesh as flat arrays, valid until lodestream_release_mesh(). */
lodestream_mesh* lodestream_take_mesh(const lodestream_cut* cut, size_t part, lodestream_arrays* arrays);
void lodestream_release_mesh(lodestream_mesh* mesh);

/* Returns a loaded tile. Coarse levels come first; draw them while finer tiles are missing. */
int lodestream_cut_tile(const lodestream_cut* cut, size_t number, lodestream_tile* tile);
/* Returns the size of a texture. number: less than lodestream_cut_info.textures. */
int lodestream_cut_texture(const lodestream_cut* cut, size_t number, lodestream_texture* texture);

#ifdef __cplusplus
}  // extern "C"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

/// C++ wrapper of the C API: classes release their handles, and functions report errors as exceptions.
namespace lodestream {

using Options = lodestream_options;
using View = lodestream_view;
using Status = lodestream_status;
using Model = lodestream_model;
using Part = lodestream_part;
using Tile = lodestream_tile;
using Texture = lodestream_texture;

/// An error with the text of lodestream_last_error().
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

/// The arrays of a part's mesh. Move only.
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

/// A reference to a cut; empty if there is no cut yet. Copies share the cut.
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
  /// Returns the numbers of the parts to draw for a camera: see lodestream_cut_shown().
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

/// A stream. Move only.
class Stream {
 public:
  explicit Stream(const std::string& url, const Options& options = defaultOptions())
      : handle_(lodestream_open(url.c_str(), &options)) {
    Error::unless(handle_ != nullptr);
  }
  /// Waits for a change: see lodestream_step(). @throws Error on failure, or if the stream has ended.
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
