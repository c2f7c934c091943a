// An `if` without `else`, for work that whole groups of pixels or vertices need not do. It is a loop that
// runs at most once: software renderers skip a loop that none of a group runs, but not a branch. Every
// shader begins with this file.
#define SKIPPABLE_IF(condition) for (int turn = (condition) ? 0 : 1; turn < 1; ++turn)
