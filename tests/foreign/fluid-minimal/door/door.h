/* The part of iceoryx2 that a solver of Bedload needs. A port is a number: 0, 1, ... of its kind, in the order in
 * which they were made. Every int is -1 after an error, every pointer NULL; door_error() says what went wrong. */
#ifndef DOOR_H
#define DOOR_H

#include <stddef.h>
#include <stdint.h>

typedef struct Door Door; /* a node and its ports */

typedef struct {
    const char *service;
    const char *type; /* name of the payload's type */
    size_t size;      /* bytes of one element */
    int slice;        /* 1: a message is a slice of elements, 0: it is one element */
    const char *header; /* name of the user header's type, NULL without one */
    size_t header_size;
} Topic;

const char *door_error(void);

/* A node of this name in the domain of root and prefix; clean-up of dead nodes and signal handlers are off. */
Door *door_open(const char *root, const char *prefix, const char *name);
/* Ports first, then the node. */
void door_close(Door *door);
/* Process id of the living node of this name, 0 if there is none. */
int door_process(Door *door, const char *name);
/* The value of an attribute of a publish-subscribe service, into room bytes. */
int door_attribute(Door *door, const char *service, const char *key, char *value, size_t room);

/* Opens a service that exists, and makes a port of it; longest: most elements of a message. */
int door_publisher(Door *door, const Topic *topic, size_t longest);
int door_subscriber(Door *door, const Topic *topic);
/* Ports that all processes have at the service of this one. */
int door_subscribers(Door *door, int publisher);
int door_publishers(Door *door, int subscriber);
/* Connects every port to the ports that have come since. */
int door_connect(Door *door);

/* Room in shared memory for a message of count elements; header is set if the topic has one. */
void *door_loan(Door *door, int publisher, size_t count, void **header);
/* Sends what was loaned; the number of subscribers that have it. */
int door_send(Door *door, int publisher);
/* Takes the next message, valid until the next call of this subscriber: 1, or 0 if there is none. */
int door_receive(Door *door, int subscriber, const void **elements, size_t *count, const void **header);

int door_notifier(Door *door, const char *service);
int door_notify(Door *door, int notifier);
int door_listener(Door *door, const char *service);
/* Waits for a notification, at most so many microseconds. */
int door_wait(Door *door, int listener, uint64_t microseconds);

#endif
