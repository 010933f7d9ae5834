#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/passes/section.h"

namespace lode::app {

/// A colour of the cut that the panel offers.
struct CapColour {
  std::string_view name;
  glm::vec3 srgb;  ///< 0 to 1
};
constexpr std::array<CapColour, 4> kCapColours{{{"red", {0.80f, 0.45f, 0.35f}},
                                                {"yellow", {0.88f, 0.72f, 0.35f}},
                                                {"blue", {0.35f, 0.55f, 0.80f}},
                                                {"white", {0.92f, 0.92f, 0.92f}}}};

/// The plane with which the user cuts the model open, perpendicular to an axis. Only a drag moves the plane:
/// it stays in place when models are hidden, shown or added. Pure.
class SectionPlane {
 public:
  /// Steps from no section through the x, y and z axes and back to none. Each section begins in the middle of
  /// the box.
  void step(const core::ModelBox& box) noexcept;
  /// Shows the other half.
  void flip() noexcept { is_flipped_ = !is_flipped_; }
  /// Moves the plane along its axis, so that it follows the pointer. If the axis points at the viewer, an
  /// upward drag moves the plane away. The plane stops at the sides of the box.
  /// @param distance_model  distance along the view direction at which the plane follows the pointer.
  void drag(const glm::dvec2& pixels, const core::View& view, double distance_model,
            const core::ModelBox& box) noexcept;
  void colour(size_t number) noexcept { colour_ = number; }
  size_t colour() const noexcept { return colour_; }  ///< index into kCapColours

  bool isOn() const noexcept { return axis_ < 3; }
  /// Returns the plane in the frame of the boxes; nothing if there is no section.
  std::optional<render::Section> section() const noexcept;
  /// Describes the section by its place in a box: "section across x at 12 %".
  std::string describe(const core::ModelBox& box) const;

 private:
  int axis_ = 3;            ///< 0 to 2; 3: no section
  double place_model_ = 0;  ///< coordinate of the plane
  bool is_flipped_ = false;
  size_t colour_ = 0;
};

/// The part of a ray on the shown side of a section.
struct ShownRay {
  glm::dvec3 origin_model;
  double most_model;           ///< length of the part; may be infinite
  bool begins_in_cut = false;  ///< true if the part begins at the plane
};
/// Cuts a ray at a section plane. @param direction  unit length. @return nothing if all of the ray is cut
/// off. Pure.
std::optional<ShownRay> shownRay(const glm::dvec3& origin_model, const glm::dvec3& direction,
                                 const render::Section& section) noexcept;

}  // namespace lode::app
