#include "client/render/culling/depth_reader.h"

namespace lode::render {

FarthestDepths DepthReader::read(const Framebuffer& picture) {
  FarthestDepths farthest{squareCount(picture.widthPx()), squareCount(picture.heightPx()), {}};
  const auto columns = static_cast<GLsizei>(farthest.columns), rows = static_cast<GLsizei>(farthest.rows);
  if (farthest.columns != columns_ || farthest.rows != rows_) {
    columns_ = farthest.columns;
    rows_ = farthest.rows;
    texels_ = GlRenderbuffer::create();
    glNamedRenderbufferStorage(texels_.get(), GL_R32F, columns, rows);
    framebuffer_ = GlFramebuffer::create();
    glNamedFramebufferRenderbuffer(framebuffer_.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, texels_.get());
  }
  squares_.draw(picture, framebuffer_.get());
  farthest.depths.resize(size_t{farthest.columns} * farthest.rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, columns, rows, GL_RED, GL_FLOAT, farthest.depths.data());
  return farthest;
}

}  // namespace lode::render
