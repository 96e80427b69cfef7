/* A shared library that is no plug-in. */
int not_touchstone_plugin(void);
int not_touchstone_plugin(void) { return 0; }
