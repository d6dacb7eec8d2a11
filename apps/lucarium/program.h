// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The program from its arguments to its exit code. Nothing is thrown.
extern "C" [[gnu::visibility("default")]] int lucarium_main(int argc, char** argv);
