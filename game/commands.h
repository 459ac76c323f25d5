/*
 * The subcommands of the stilb program, one folder each. argv[0] is the first argument after the subcommand's name,
 * argc the number of arguments. Each prints its own errors and returns the exit code of the program: EXIT_DONE,
 * EXIT_FAILED or EXIT_REFUSED (flags.h). All are [main-thread] and called at most once.
 */
#ifndef STILB_COMMANDS_H
#define STILB_COMMANDS_H

int bake_command(int argc, char **argv);
int bench_command(int argc, char **argv); /* replaces the process by stilb-bench; returns only if that fails */
int demo_command(int argc, char **argv);
int info_command(int argc, char **argv);
int pads_command(int argc, char **argv);
int offline_command(int argc, char **argv); /* stilb render; the prefix render_ is engine/render's */
int replay_command(int argc, char **argv);
int shade_command(int argc, char **argv);
int trace_command(int argc, char **argv);
int view_command(int argc, char **argv);

#endif
