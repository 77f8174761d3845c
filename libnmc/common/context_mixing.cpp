// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/context_mixing.h"

#if !defined(NMC_TABLES_MADE_AT_START)

namespace nmc::mixing_internal {

namespace {

template <class Table>
constexpr Table filled_table() {
  Table table{};
  fill(table);
  return table;
}

}  // namespace

constinit const CountTable kCountTable = filled_table<CountTable>();
constinit const StretchTable kStretch = filled_table<StretchTable>();

}  // namespace nmc::mixing_internal

#endif
