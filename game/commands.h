/* The subcommands: one file each. argv[0] is the first argument after the subcommand's name; returns the exit code. */
#ifndef STILB_COMMANDS_H
#define STILB_COMMANDS_H

int bench_command(int argc, char **argv); /* becomes stilb-bench: returns only when it cannot */
int demo_command(int argc, char **argv);
int info_command(int argc, char **argv);
int pads_command(int argc, char **argv);
int offline_command(int argc, char **argv);
int replay_command(int argc, char **argv);
int shade_command(int argc, char **argv);
int trace_command(int argc, char **argv);

#endif
