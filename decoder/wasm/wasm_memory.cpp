// SPDX-License-Identifier: Apache-2.0
// malloc and free for a module whose decoder holds a few dozen arrays: first fit over a list of free blocks in order of
// address, which are joined when they touch. A tenth of the code of a general allocator.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

extern "C" unsigned char __heap_base;  // set by the linker

namespace {

constexpr std::size_t kAlignment = 16;
constexpr std::size_t kPage = 65536;

/// Stands before each block, and before each free block with the address of the next.
struct Block {
  std::size_t size;  // of the block with this head, a multiple of kAlignment
  Block* next;
  std::size_t unused[2];
};
static_assert(sizeof(Block) == kAlignment || sizeof(void*) != 4);

Block* g_free = nullptr;
std::uintptr_t g_end = 0;  // of the memory that was taken so far

Block* take_pages(std::size_t size) {
  if (g_end == 0) g_end = (reinterpret_cast<std::uintptr_t>(&__heap_base) + kAlignment - 1) & ~(kAlignment - 1);
  const std::uintptr_t start = g_end;
  if (size > ~std::uintptr_t{0} - start - kPage) return nullptr;
  const std::size_t present = static_cast<std::size_t>(__builtin_wasm_memory_size(0)) * kPage;
  if (start + size > present) {
    const std::size_t pages = (start + size - present + kPage - 1) / kPage;
    if (__builtin_wasm_memory_grow(0, pages) == ~std::size_t{0}) return nullptr;
  }
  g_end = start + size;
  Block* block = reinterpret_cast<Block*>(start);
  block->size = size;
  return block;
}

}  // namespace

extern "C" void* malloc(std::size_t count) {
  if (count > ~std::size_t{0} / 2) return nullptr;
  const std::size_t size = (count + sizeof(Block) + kAlignment - 1) & ~(kAlignment - 1);
  for (Block** link = &g_free; *link; link = &(*link)->next) {
    Block* block = *link;
    if (block->size < size) continue;
    if (block->size - size >= 4 * sizeof(Block)) {  // the rest stays free
      Block* rest = reinterpret_cast<Block*>(reinterpret_cast<unsigned char*>(block) + size);
      rest->size = block->size - size;
      rest->next = block->next;
      block->size = size;
      *link = rest;
    } else {
      *link = block->next;
    }
    return block + 1;
  }
  Block* block = take_pages(size);
  return block ? block + 1 : nullptr;
}

extern "C" void free(void* pointer) {
  if (!pointer) return;
  Block* block = static_cast<Block*>(pointer) - 1;
  Block* before = nullptr;
  Block* after = g_free;
  while (after && after < block) {
    before = after;
    after = after->next;
  }
  const auto end_of = [](Block* b) { return reinterpret_cast<Block*>(reinterpret_cast<unsigned char*>(b) + b->size); };
  block->next = after;
  if (after && end_of(block) == after) {
    block->size += after->size;
    block->next = after->next;
  }
  if (!before) {
    g_free = block;
  } else if (end_of(before) == block) {
    before->size += block->size;
    before->next = block->next;
    block = before;
  } else {
    before->next = block;
  }
  // What is free at the end is given back to the next take_pages().
  if (reinterpret_cast<std::uintptr_t>(end_of(block)) == g_end) {
    g_end = reinterpret_cast<std::uintptr_t>(block);
    Block** link = &g_free;
    while (*link != block) link = &(*link)->next;
    *link = nullptr;
  }
}
