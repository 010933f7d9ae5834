// Empty source for the targets of cmake/LodePrecompiled.cmake, because a target needs a source.
