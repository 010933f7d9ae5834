#include "client/app/cli/common_options.h"
#include "client/app/cli/program.h"
#include "client/loadtest/loadtest_command.h"
#include "common/io/interrupted.h"
#ifdef LODE_GL
#include "client/app/window/render_command.h"
#include "client/app/window/view_command.h"
#endif

namespace {

using namespace lode::app;

void declareCommands(CLI::App& program, int& exit_status) {
#ifdef LODE_GL
  declareView(program, exit_status);
  declareRender(program, exit_status);
#else
  for (const char* name : {"view", "render"})
    declareMissing(program, name, "built without OpenGL; use a build with it");
#endif
  declareFetch(program, exit_status);
  declareReplay(program, exit_status);
  declareLoadtest(program, exit_status);
  declareList(program, exit_status);
}

}  // namespace

int main(int argc, char** argv) {
  lode::endCleanlyWhenInterrupted();
  return runProgram(argc, argv, declareCommands);
}
