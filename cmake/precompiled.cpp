// Compiled with each set of cmake/LodePrecompiled.cmake, for a target needs a source.
