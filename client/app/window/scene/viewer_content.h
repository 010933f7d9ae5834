#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/window/camera/walk_camera.h"
#include "client/app/window/scene/picks.h"
#include "client/core/view/framing.h"
#include "client/core/view/view.h"
#include "client/render/framebuffer.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"
#include "common/error.h"

namespace lode::app {

/// Whether a scene may be shown of which models cannot be opened.
enum class Lacking : uint8_t { kRefused, kShown };

/// What the window shows: a model or a scene, which opens beside the window's thread, streams and is drawn.
/// Views and points are in the frame of summary(). For the window's thread.
class ViewerContent {
 public:
  struct Opening {
    std::string phase = {};  ///< what is being done,
    double part = -1;        ///< and how much of it, 0 to 1; below: unknown
    bool is_open = false;
    std::optional<Error> error = std::nullopt;
  };
  virtual ~ViewerContent() = default;

  /// Looks how far it has come, without waiting. What is below is for when it is open.
  virtual Opening open() = 0;
  /// Of the whole: its name, place, size and triangles.
  virtual const ModelSummary& summary() const = 0;
  /// What builds of its models have warned of.
  virtual std::vector<std::string> warnings() const = 0;
  /// Which models of it are not there, and why: a line for each.
  virtual std::vector<std::string> missing() const { return {}; }
  /// It is not to be stood on another side.
  virtual bool saysWhatIsUp() const { return false; }
  /// What a first camera is made of.
  virtual core::Framing framing() const = 0;

  /// Another budget from now on, of all its streams and of what is on the GPU together.
  virtual void setMemory(uint64_t budget_bytes) = 0;
  /// Asks for what this camera needs, and takes what has come.
  virtual void look(const core::View& view, float threshold_px) = 0;
  /// About the view last looked from; of several streams what they say together. The cut of a scene has no
  /// parts: it says how far all have come.
  virtual const stream::StreamStatus& status() const = 0;
  virtual void uploadInRenderThread() = 0;
  /// Nothing is left to upload; or there is no room for it.
  virtual bool upToDate() const = 0;
  virtual bool overBudget() const = 0;
  /// Of every model either all is on the GPU or no more has room there.
  virtual bool uploaded() const = 0;

  virtual render::DrawCounts draw(const core::View& view, const render::Framebuffer& target,
                                  render::DrawStyle style, const render::DrawTime& time) = 0;
  /// What the last picture was made of.
  virtual std::span<const render::DrawItem> inPicture() const = 0;
  /// Of the coarsest cut that is drawn: see core::thresholdRad(); 0 while nothing is.
  virtual double drawnThresholdRad() const = 0;
  /// Grows with each cut that comes to be drawn.
  virtual uint64_t drawnSerial() const = 0;
  /// The next picture differs from the last although nothing has come: see render::Renderer.
  virtual bool fading() const = 0;
  virtual bool ageing() const = 0;

  struct GpuUse {
    uint64_t bytes = 0, tiles = 0;
    bool textured = false;
  };
  virtual GpuUse gpuUse() const = 0;

  /// What is drawn at a place of the picture. @param place_px  from its top left corner.
  virtual std::optional<PickedPoint> under(const core::View& view, const glm::dvec2& place_px) = 0;
  /// What is drawn straight below a point. @param up  of unit length.
  virtual std::optional<render::Ground> groundBelow(const core::View& view, const glm::dvec3& point_model,
                                                    const glm::dvec3& up) = 0;
};

}  // namespace lode::app
