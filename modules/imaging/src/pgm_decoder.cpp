// pgm_decoder
