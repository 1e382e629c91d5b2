// common_turns.glsl: how loops count and how rare work is kept rare, which is up to the driver.
// Needs DRIVER_LLVMPIPE, SAMPLE_TURNS. Gives TURN, TURNS(n), TURNS_LEFT, ONCE(condition).

#if DRIVER_LLVMPIPE
// llvmpipe ends every loop, without a word, after 65535 turns of all loops of the invocations that it runs side by
// side, up to 16. A ray counts its turns, also those of short loops that a compiler may or may not unroll. It goes on
// in another dispatch when its share is spent; the rest of the share is for one more sample.
int gTurns = 0;
const int kMostTurns = 65535 / 16 - 400 - SAMPLE_TURNS; // those of the features in use
#define TURN ++gTurns
#define TURNS(n) gTurns += n
#define TURNS_LEFT (gTurns < kMostTurns)
// It runs both sides of a branch for all lanes, but a loop only as long as a lane needs it. Neither break nor
// continue may stand in the text after ONCE: they would mean another loop elsewhere.
#define ONCE(condition) for (int once = int(condition); once != 0; once &= once - 1, ++gTurns)
#else
#define TURN
#define TURNS(n)
#define TURNS_LEFT true
#define ONCE(condition) if (condition)
#endif
