// SPDX-License-Identifier: Apache-2.0
// A plug-in with one mistake, chosen by a macro.
#include <cstdlib>
#include <exception>

#include "lucarium/technique/plugin.h"

namespace {

/// An exception type of the plug-in's own: its code is gone when the plug-in has been closed.
struct PluginException : std::exception {
  const char* what() const noexcept override { return "an exception of the plug-in's own"; }
};

#if defined(UNDEFINED_SYMBOL)
extern "C" void lucarium_test_nobody_defines_this();
#endif

[[maybe_unused]] lucarium::TechniqueInfo info() {
#if defined(WRONG_MAGIC) || defined(WRONG_ABI) || defined(WRONG_COMPILER) || defined(WRONG_SANITIZER)
  std::abort();  // nothing may be called before the header is found good
#elif defined(THROWS_IN_INFO)
  throw PluginException();
#elif defined(THROWS_AN_INT)
  throw 7;
#endif
  lucarium::TechniqueInfo result;
  result.name = "throws_in_create";
#if defined(BAD_NAME)
  result.name = "bad name:x=1";
#elif defined(UNDEFINED_SYMBOL)
  lucarium_test_nobody_defines_this();
#endif
  return result;
}

[[maybe_unused]] std::unique_ptr<lucarium::Technique> create() { throw PluginException(); }

}  // namespace

#if defined(NO_DESCRIPTOR)
extern "C" __attribute__((visibility("default"))) const lucarium::TechniqueDescriptor* lucarium_technique() {
  return nullptr;
}
#elif !defined(NO_SYMBOL)
extern "C" __attribute__((visibility("default"))) const lucarium::TechniqueDescriptor* lucarium_technique() {
  static lucarium::TechniqueDescriptor descriptor = {lucarium::detail::plugin_header(), info, create};
  lucarium::PluginHeader& header = descriptor.header;
#if defined(WRONG_MAGIC)
  header.magic[0] = 'X';
#elif defined(WRONG_ABI)
  header.abi += 1;
#elif defined(WRONG_COMPILER)
  header.compiler[0] = '?';
#elif defined(WRONG_SANITIZER)
  header.sanitizers[0] = 'm';
#endif
  static_cast<void>(header);
  return &descriptor;
}
#endif
